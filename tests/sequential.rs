//! Sequential ADELM makes families of minima as published.

use landscape::energy::model::MullerBrown;
use landscape::optimize::QuenchSettings;
use landscape::sample::Mala;
use landscape::topography::{
    ChainSettings, MatchTolerance, MinimumId, Run, SequentialSettings, distinct, quench_all,
    sequential,
};

#[test]
fn published_surface() {
    // A strong pull joins all of Müller and Brown's minima, a weak one only those 8.5 apart, less than twice T.
    let energy = MullerBrown::new();
    let kernel = Mala::new(&energy);
    let starts = [vec![0.62, 0.03], vec![-0.05, 0.47], vec![-0.56, 1.44]];
    let found = quench_all(
        &energy,
        &starts,
        &QuenchSettings::default(),
        &Run::default(),
    )
    .unwrap();
    let (minima, _) = distinct(&energy, &found, &MatchTolerance::default(), 1e-6);
    let families = |force| {
        let scales = SequentialSettings::for_scales(50.0, 1.0);
        let settings = SequentialSettings {
            chain: ChainSettings {
                temperature: 5.0,
                force,
                max_steps: 20_000,
                patience: 500,
                ..scales.chain.clone()
            },
            ..scales
        };
        let found = sequential(&energy, &kernel, &minima, &settings, &Run::default()).unwrap();
        (found.landscape.families.members.len(), found)
    };
    let (one, all) = families(1000.0);
    assert_eq!(one, 1);
    let ids = |ids: &[usize]| ids.iter().map(|id| MinimumId(*id)).collect::<Vec<_>>();
    let (_, some) = families(2.0);
    assert_eq!(some.landscape.families.members, [ids(&[0]), ids(&[1, 2])]);
    // Upper bounds, up to the length of a step.
    let height = all
        .landscape
        .tree
        .minimax(MinimumId(0), MinimumId(1))
        .unwrap();
    assert!(height > -40.67 - 0.05 && height < 60.0, "{height}");
}
