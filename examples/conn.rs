//! scratch
use landscape::energy::Energy;
use landscape::grasp::hand::Hand;
use landscape::grasp::object::Object;
use landscape::grasp::*;
use landscape::optimize::*;
use landscape::space::Space;
use landscape::store::*;
use landscape::topography::*;
use rayon::prelude::*;
use std::sync::Arc;
use std::time::Instant;
fn main() {
    let npairs: usize = std::env::args().nth(1).map_or(24, |s| s.parse().unwrap());
    let (file, _) = GraspFile::read("/tmp/s/pop3.parquet".as_ref(), Overrides::default()).unwrap();
    let hand = Arc::new(Hand::human());
    let object = Arc::new(Object::named("bottle_round").unwrap());
    let r: f64 = std::env::var("ROUND").map_or(0.001, |s| s.parse().unwrap());
    let energy = GraspEnergy::new(
        hand,
        object,
        EnergySettings {
            distance_rounding_m: r,
            ..EnergySettings::default()
        },
    )
    .unwrap();
    let starts: Vec<Vec<f64>> = file
        .grasps
        .iter()
        .map(|g| {
            let mut x = g.translation_m.to_vec();
            x.extend(g.rotation_wxyz);
            x.extend(&g.joints_rad);
            x
        })
        .collect();
    let q = QuenchSettings::default()
        .with_gradient_tolerance(1e-5)
        .with_max_step(0.01);
    let t = Instant::now();
    let found = quench_all(&energy, &starts, &q, &NoJournal, &silent);
    println!(
        "quench {:?} evals {} ",
        t.elapsed(),
        found.iter().map(|f| f.evaluations).sum::<usize>()
    );
    let mut stops = std::collections::BTreeMap::new();
    for f in &found {
        *stops.entry(format!("{:?}", f.stop)).or_insert(0) += 1;
    }
    println!("{stops:?}");
    let mut gn: Vec<f64> = found.iter().map(|f| f.gradient_norm).collect();
    gn.sort_by(f64::total_cmp);
    println!("gnorm {:?}", [0, 100, 200, 300, 380, 399].map(|i| gn[i]));
    let sameness = Sameness {
        energy: 0.05,
        distance: 5e-3,
    };
    let (minima, rejected) = distinct(&energy, &found, &sameness, 1e9);
    println!("minima {} rejected {}", minima.len(), rejected.len());
    let space = energy.space();
    let n = minima.len();
    let t = Instant::now();
    let mut pairs = vec![];
    for i in 0..n {
        let mut d: Vec<(f64, usize)> = (0..n)
            .filter(|&j| j != i)
            .map(|j| {
                (
                    space.distance(&minima[i].coordinates, &minima[j].coordinates),
                    j,
                )
            })
            .collect();
        d.sort_by(|a, b| a.0.total_cmp(&b.0));
        for k in 0..8 {
            let j = d[k].1;
            pairs.push((i.min(j), i.max(j), d[k].0));
        }
    }
    pairs.sort_by(|a, b| (a.0, a.1).cmp(&(b.0, b.1)));
    pairs.dedup_by(|a, b| (a.0, a.1) == (b.0, b.1));
    let mut nn: Vec<f64> = pairs.iter().map(|p| p.2).collect();
    nn.sort_by(f64::total_cmp);
    println!(
        "pairs {} {:?} distances {:?}",
        pairs.len(),
        t.elapsed(),
        [0, nn.len() / 4, nn.len() / 2, nn.len() - 1].map(|i| nn[i])
    );
    let step = pairs.len() / npairs;
    let chosen: Vec<_> = (0..npairs).map(|i| pairs[i * step]).collect();
    let f: f64 = std::env::args()
        .nth(2)
        .map_or(210.0, |s| s.parse().unwrap());
    let chain = ChainSettings {
        temperature: 0.01,
        force: f,
        escalation: 1.6,
        attempts: 1,
        replicas: 1,
        step: 1e-3,
        arrival: 0.005,
        patience: 150,
        max_steps: 1500,
        spacing: 0.004,
    };
    let path = PathSettings {
        max_step: 0.004,
        force_tolerance: 35.0,
        energy_tolerance: 1e-2,
        segments: 20,
        exact_below: 0.5,
        rounds: 3,
        iterations: 30,
        coarse_iterations: 36,
        ..PathSettings::for_scales(0.3, 0.05)
    };
    println!("{path:?}");
    let conn = Connector {
        chain: &chain,
        path: &path,
        quench: &q,
        sameness: &sameness,
    };
    let kernel = GraspKernel::new(&energy);
    let t = Instant::now();
    let out: Vec<(Connection, f64)> = chosen
        .par_iter()
        .map(|&(i, j, _)| {
            let t = Instant::now();
            let c = conn.connect(
                &energy,
                &kernel,
                (MinimumId(i), MinimumId(j)),
                (&minima[i], &minima[j]),
                Effort {
                    attempt: 0,
                    seed: 0,
                },
                None,
            );
            (c, t.elapsed().as_secs_f64())
        })
        .collect();
    let el = t.elapsed().as_secs_f64();
    let mut ev = std::collections::BTreeMap::new();
    for ((c, s), p) in out.iter().zip(&chosen) {
        *ev.entry(format!("{:?}", c.edge.evidence)).or_insert(0) += 1;
        let floor = minima[p.0].energy.max(minima[p.1].energy);
        println!(
            "{:?} d {:.3} rel {:.3} {:?} {:?} len {:.3} fwd {:?} bwd {:?} start {:?} obj {:?} crossings {} evals {} {:.2}s",
            (p.0, p.1),
            p.2,
            c.edge.height - floor,
            c.edge.evidence,
            c.edge.term,
            c.edge.length,
            c.forward
                .iter()
                .map(|b| b.map(|b| ((b - floor) * 1e3).round() / 1e3))
                .collect::<Vec<_>>(),
            c.backward
                .iter()
                .map(|b| b.map(|b| ((b - floor) * 1e3).round() / 1e3))
                .collect::<Vec<_>>(),
            c.start,
            c.objection,
            c.crossings.len(),
            c.evaluations,
            s
        );
    }
    println!(
        "{ev:?} total {el:.1}s => {:.2}s per pair; mean evals {}",
        el / npairs as f64,
        out.iter().map(|o| o.0.evaluations).sum::<usize>() / npairs
    );
}
