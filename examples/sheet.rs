//! scratch: contact sheet as PPM
use landscape::figure::scene::*;
use landscape::grasp::hand::{Hand, PosedHand};
use landscape::grasp::object::Object;
use landscape::store::*;
use nalgebra::Vector3;
use rayon::prelude::*;
fn main() {
    let path = std::env::args().nth(1).unwrap();
    let out = std::env::args().nth(2).unwrap();
    let (file, _) = GraspFile::read(path.as_ref(), Overrides::default()).unwrap();
    let hand = Hand::human();
    let skin = hand.skin();
    let object = Object::named(&file.metadata.objects[0].name).unwrap();
    let n = file.grasps.len();
    let picks: Vec<usize> = (0..60.min(n)).map(|i| i * n / 60.min(n)).collect();
    let (w, h, cols) = (260usize, 260usize, 10usize);
    let images: Vec<Image> = picks.par_iter().map(|&i| {
        let g = &file.grasps[i];
        let mut x = g.translation_m.to_vec(); x.extend(g.rotation_wxyz); x.extend(&g.joints_rad);
        let mut posed = PosedHand::default();
        hand.pose(&x, &mut posed);
        let mut scene = Scene::new();
        scene.mesh(skin.pose(&posed), skin.triangles.clone(), [235, 190, 160]);
        scene.mesh(object.mesh.vertices().to_vec(), object.mesh.triangles().to_vec(), [120, 160, 190]);
        for &c in &g.contacts { scene.ball(&posed.points[c as usize], 0.006, [220, 30, 30]); }
        let up = Vector3::z();
        let d = scene.best_direction(&up, [220, 30, 30]);
        scene.render(&d, &up, w, h)
    }).collect();
    let rows = images.len().div_ceil(cols);
    let mut rgb = vec![255u8; 3 * w * cols * h * rows];
    for (k, image) in images.iter().enumerate() {
        let (r, c) = (k / cols, k % cols);
        for y in 0..h { let to = 3 * ((r * h + y) * w * cols + c * w); rgb[to..to + 3 * w].copy_from_slice(&image.rgb[3 * y * w..3 * (y + 1) * w]); }
    }
    let mut bytes = format!("P6\n{} {}\n255\n", w * cols, h * rows).into_bytes();
    bytes.extend(rgb);
    std::fs::write(out, bytes).unwrap();
}
