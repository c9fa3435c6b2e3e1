//! scratch
use landscape::energy::Energy;
use landscape::grasp::hand::Hand;
use landscape::grasp::object::Object;
use landscape::grasp::synthesis::*;
use landscape::grasp::*;
use landscape::sample::*;
use landscape::space::Space;
use rayon::prelude::*;
use std::sync::Arc;
use std::time::Instant;
fn main() {
    let t = Instant::now();
    let hand = Arc::new(Hand::human());
    println!(
        "hand {:?} points {} capsules {} pairs {} joints {}",
        t.elapsed(),
        hand.surface.len(),
        hand.capsules.len(),
        hand.self_pairs.len(),
        hand.joints.len()
    );
    let t = Instant::now();
    let object = Arc::new(Object::load("data/objects/bottle_round.obj").unwrap());
    println!(
        "object {:?} {:?} radius {}",
        t.elapsed(),
        object.field_report,
        object.radius_m
    );
    for settings in [
        EnergySettings::default(),
        EnergySettings {
            contacts: 3,
            ..EnergySettings::default()
        },
        EnergySettings::paper(),
    ] {
        let energy = GraspEnergy::new(hand.clone(), object.clone(), settings).unwrap();
        let mut rng = stream(1, Task::Start, 0);
        // gradient check
        let n = energy.space().tangents();
        let mut worst = 0.0f64;
        for _ in 0..20 {
            let x = start::start_pose(&hand, &object, &mut rng);
            let choice = energy.choice(&x);
            let mut g = vec![0.0; n];
            let mut dummy = vec![0.0; n];
            let e = energy.evaluate_choice(&x, &choice, &mut g);
            let e2 = energy.evaluate(&x, &mut dummy);
            assert!((e - e2).abs() < 1e-9, "{e} {e2}");
            for k in 0..n {
                let h = 1e-7;
                let mut t = vec![0.0; n];
                t[k] = h;
                let mut a = x.clone();
                energy.space().shift(&mut a, &t);
                t[k] = -h;
                let mut b = x.clone();
                energy.space().shift(&mut b, &t);
                let d = (energy.evaluate_choice(&a, &choice, &mut dummy)
                    - energy.evaluate_choice(&b, &choice, &mut dummy))
                    / (2.0 * h);
                let err = (d - g[k]).abs() / (1.0 + g[k].abs());
                if err > 1e-4 {
                    let ta = energy.terms_of(&a, &choice);
                    let tb = energy.terms_of(&b, &choice);
                    for (u, v) in ta.iter().zip(&tb) {
                        println!("   {} {}", u.0, (u.1 - v.1) / (2.0 * h));
                    }
                    println!("k {k} fd {d} an {} e {e}", g[k]);
                }
                worst = worst.max(err);
            }
        }
        println!("gradient worst {worst:e}");
        // timing
        let mut xs = vec![];
        let mut x = start::start_pose(&hand, &object, &mut rng);
        let choice = energy.choice(&x);
        use rand::RngExt;
        for _ in 0..2000 {
            let t: Vec<f64> = (0..n).map(|_| rng.random_range(-2e-4..2e-4)).collect();
            energy.space().shift(&mut x, &t);
            xs.push(x.clone());
        }
        let mut g = vec![0.0; n];
        let t = Instant::now();
        for x in &xs {
            energy.evaluate_choice(x, &choice, &mut g);
        }
        println!("choice eval {:?}", t.elapsed() / 2000);
        let t = Instant::now();
        for x in &xs {
            energy.evaluate(x, &mut g);
        }
        println!("envelope eval {:?}", t.elapsed() / 2000);
    }
    let chains: u64 = std::env::args().nth(1).map_or(16, |s| s.parse().unwrap());
    let steps: u32 = std::env::args().nth(2).map_or(2000, |s| s.parse().unwrap());
    for n in [4] {
        let energy = GraspEnergy::new(
            hand.clone(),
            object.clone(),
            EnergySettings {
                contacts: n,
                ..EnergySettings::default()
            },
        )
        .unwrap();
        let s = SynthesisSettings {
            steps,
            ..SynthesisSettings::default()
        };
        let t = Instant::now();
        let out: Vec<_> = (0..chains)
            .into_par_iter()
            .map(|c| {
                synthesize(
                    &energy,
                    &s,
                    &landscape::optimize::QuenchSettings::default(),
                    1,
                    c,
                )
            })
            .collect();
        let el = t.elapsed();
        let judged: Vec<_> = out
            .iter()
            .map(|o| {
                (
                    judge(&energy, &o.raw, &o.raw_contacts),
                    judge(&energy, &o.refined, &o.contacts),
                )
            })
            .collect();
        for (o, (a, b)) in out.iter().zip(&judged).take(12) {
            println!(
                "E {:.3} raw gc {:.2} gap {:.1}mm deep {:.1} self {:.1} | refined {:?} gc {:.2} gap {:.2} deep {:.2} mu {:?} digits {}  {:?}",
                o.energy,
                a.net_wrench,
                a.gap_m * 1e3,
                a.deepest_m * 1e3,
                a.self_penetration_m * 1e3,
                b.strict_objection(),
                b.net_wrench,
                b.gap_m * 1e3,
                b.deepest_m * 1e3,
                b.least_friction,
                b.digits,
                energy
                    .terms_of(&o.refined, &o.contacts)
                    .iter()
                    .map(|(n, v)| format!("{}={:.3}", &n[..5], v))
                    .collect::<Vec<_>>()
            );
        }
        println!(
            "n {n} time {el:?}  raw eq11 {} strict {} refined eq11 {} strict {}",
            judged.iter().filter(|j| j.0.passes_published()).count(),
            judged.iter().filter(|j| j.0.passes_strict()).count(),
            judged.iter().filter(|j| j.1.passes_published()).count(),
            judged.iter().filter(|j| j.1.passes_strict()).count()
        );
        // warm envelope at refined grasps
        let good: Vec<_> = out
            .iter()
            .zip(&judged)
            .filter(|(_, j)| j.1.passes_strict())
            .map(|(o, _)| o)
            .take(8)
            .collect();
        let (mut te, mut tc, mut count) = (0.0, 0.0, 0);
        let mut rng = stream(3, Task::Start, 0);
        for amp in [1e-4, 5e-4] {
            for o in &good {
                use rand::RngExt;
                let nt = energy.space().tangents();
                let mut x = o.refined.clone();
                let mut g = vec![0.0; nt];
                energy.evaluate(&x, &mut g);
                for _ in 0..200 {
                    let t: Vec<f64> = (0..nt).map(|_| rng.random_range(-amp..amp)).collect();
                    x = o.refined.clone();
                    energy.space().shift(&mut x, &t);
                    let t = Instant::now();
                    energy.evaluate(&x, &mut g);
                    te += t.elapsed().as_secs_f64();
                    let t = Instant::now();
                    energy.evaluate_choice(&x, &o.contacts, &mut g);
                    tc += t.elapsed().as_secs_f64();
                    count += 1;
                }
            }
            println!(
                "amp {amp} warm envelope {:.1} us, choice {:.1} us",
                te / count as f64 * 1e6,
                tc / count as f64 * 1e6
            );
        }
        let mut why = std::collections::BTreeMap::new();
        for j in &judged {
            *why.entry(j.1.strict_objection().unwrap_or("ok"))
                .or_insert(0) += 1;
        }
        println!("{why:?}");
    }
}
