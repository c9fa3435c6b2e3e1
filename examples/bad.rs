//! scratch
use landscape::energy::Energy;
use landscape::grasp::hand::Hand;
use landscape::grasp::object::Object;
use landscape::grasp::*;
use landscape::space::interpolate;
use landscape::store::*;
use std::sync::Arc;
use std::time::Instant;
fn main() {
    let (file, _) = GraspFile::read("/tmp/s/pop3.parquet".as_ref(), Overrides::default()).unwrap();
    let energy = GraspEnergy::new(
        Arc::new(Hand::human()),
        Arc::new(Object::named("bottle_round").unwrap()),
        EnergySettings::default(),
    )
    .unwrap();
    let xs: Vec<Vec<f64>> = file
        .grasps
        .iter()
        .map(|g| {
            let mut x = g.translation_m.to_vec();
            x.extend(g.rotation_wxyz);
            x.extend(&g.joints_rad);
            x
        })
        .collect();
    let mut times = vec![];
    let mut g = vec![0.0; 28];
    for k in 0..60 {
        for t in [0.3, 0.5] {
            let x = interpolate(energy.space(), &xs[k], &xs[(k * 7 + 13) % 400], t);
            let c = Instant::now();
            let e = energy.evaluate(&x, &mut g);
            let a = c.elapsed().as_secs_f64() * 1e3;
            let c = Instant::now();
            let r = energy.evaluate_roughly_above(&x, &mut g, 0.0);
            let b = c.elapsed().as_secs_f64() * 1e3;
            let terms = energy.terms(&x);
            let cont: f64 = terms
                .iter()
                .filter(|t| t.0 == "distance" || t.0 == "force_closure")
                .map(|t| t.1)
                .sum();
            times.push((a, e, cont, r, b, k));
        }
    }
    times.sort_by(|a, b| b.0.total_cmp(&a.0));
    for t in times.iter().step_by(6) {
        println!(
            "{:.2} ms E {:.2} contact part {:.3} rough {:.3} in {:.3} ms",
            t.0, t.1, t.2, t.3, t.4
        );
    }
    println!(
        "mean {:.2}",
        times.iter().map(|t| t.0).sum::<f64>() / times.len() as f64
    );
}
