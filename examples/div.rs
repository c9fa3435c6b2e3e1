//! scratch
use landscape::grasp::hand::{Hand, PosedHand};
use landscape::grasp::object::Object;
use landscape::store::*;
fn main() {
    let path = std::env::args().nth(1).unwrap();
    let (file, w) = GraspFile::read(path.as_ref(), Overrides::default()).unwrap();
    println!("{} grasps, {} warnings", file.grasps.len(), w.len());
    let hand = Hand::human();
    let object = Object::named(&file.metadata.objects[0].name).unwrap();
    let mut sets = std::collections::BTreeMap::new();
    let mut contact_sets = std::collections::BTreeMap::new();
    let mut heights = vec![];
    let mut posed = PosedHand::default();
    for g in &file.grasps {
        let mut x = g.translation_m.to_vec();
        x.extend(g.rotation_wxyz);
        x.extend(&g.joints_rad);
        hand.pose(&x, &mut posed);
        let mut touch = vec![false; hand.digits.len()];
        for (p, s) in posed.points.iter().zip(&hand.surface) {
            if object.exact.distance(p) < 0.003 {
                touch[hand.links[s.link.0].digit] = true;
            }
        }
        let name: String = touch
            .iter()
            .zip(&hand.digits)
            .filter(|(t, _)| **t)
            .map(|(_, d)| d[..1].to_uppercase())
            .collect();
        *sets.entry(name).or_insert(0) += 1;
        let mut c: Vec<usize> = g
            .contacts
            .iter()
            .map(|i| hand.links[hand.surface[*i as usize].link.0].digit)
            .collect();
        c.sort();
        c.dedup();
        *contact_sets
            .entry(
                c.iter()
                    .map(|d| hand.digits[*d][..1].to_uppercase())
                    .collect::<String>(),
            )
            .or_insert(0) += 1;
        let z: f64 = g
            .contacts
            .iter()
            .map(|i| posed.points[*i as usize].z)
            .sum::<f64>()
            / 4.0;
        heights.push(z);
    }
    let mut v: Vec<_> = sets.into_iter().collect();
    v.sort_by_key(|e| -e.1);
    println!("touching {v:?}");
    let mut v: Vec<_> = contact_sets.into_iter().collect();
    v.sort_by_key(|e| -e.1);
    println!("contacts {v:?}");
    let [lo, hi] = object.mesh.bounds();
    let mut bins = [0; 10];
    for z in heights {
        bins[(((z - lo.z) / (hi.z - lo.z)) * 10.0).clamp(0.0, 9.0) as usize] += 1;
    }
    println!("bounds {lo:?} {hi:?} heights {bins:?}");
    let mut e: Vec<f64> = file.grasps.iter().map(|g| g.energy).collect();
    e.sort_by(f64::total_cmp);
    println!(
        "E {:?}",
        [0, e.len() / 4, e.len() / 2, 3 * e.len() / 4, e.len() - 1].map(|i| e[i])
    );
    let mut f: Vec<f64> = file.grasps.iter().map(|g| g.friction.unwrap()).collect();
    f.sort_by(f64::total_cmp);
    println!(
        "mu0 {:?}",
        [0, f.len() / 4, f.len() / 2, 3 * f.len() / 4, f.len() - 1].map(|i| f[i])
    );
}
