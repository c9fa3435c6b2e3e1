//! The human hand open, at rest, as a fist, pinching and in a tripod, from two sides → `figures/hand_poses.png`

use landscape::figure::{Scene, Surface, contact_sheet};
use landscape::hand::{Hand, PosedHand};
/// Joint angles in degrees that differ from the rest pose; `*` means all others.
const POSES: [(&str, &[(&str, f64)]); 5] = [
    (
        "open",
        &[
            ("*", 0.0),
            ("thumb_cmc_flexion", -8.0),
            ("thumb_cmc_abduction", 8.0),
            ("index_mcp_abduction", 7.0),
            ("ring_mcp_abduction", -7.0),
            ("little_mcp_abduction", -14.0),
        ],
    ),
    ("rest", &[]),
    (
        "fist",
        &[
            ("thumb_cmc_flexion", 10.0),
            ("thumb_cmc_abduction", 45.0),
            ("thumb_mcp_abduction", 10.0),
            ("thumb_mcp_flexion", 10.0),
            ("thumb_ip_flexion", 66.0),
            ("index_mcp_abduction", 2.0),
            ("index_mcp_flexion", 68.0),
            ("index_pip_flexion", 105.0),
            ("index_dip_flexion", 60.0),
            ("middle_mcp_flexion", 76.0),
            ("middle_pip_flexion", 89.0),
            ("middle_dip_flexion", 57.0),
            ("ring_mcp_abduction", -4.0),
            ("ring_mcp_flexion", 84.0),
            ("ring_pip_flexion", 103.0),
            ("ring_dip_flexion", 55.0),
            ("little_mcp_abduction", -7.0),
            ("little_mcp_flexion", 85.0),
            ("little_pip_flexion", 100.0),
            ("little_dip_flexion", 56.0),
        ],
    ),
    (
        "pinch",
        &[
            ("thumb_cmc_flexion", 21.0),
            ("thumb_cmc_abduction", 32.0),
            ("thumb_mcp_abduction", 0.0),
            ("thumb_mcp_flexion", 6.0),
            ("thumb_ip_flexion", -5.0),
            ("index_mcp_abduction", -8.0),
            ("index_mcp_flexion", 44.0),
            ("index_pip_flexion", 40.0),
            ("index_dip_flexion", 23.0),
        ],
    ),
    (
        "tripod",
        &[
            ("thumb_cmc_flexion", 23.0),
            ("thumb_cmc_abduction", 32.0),
            ("thumb_mcp_abduction", 1.0),
            ("thumb_mcp_flexion", 8.0),
            ("thumb_ip_flexion", -7.0),
            ("index_mcp_abduction", -4.0),
            ("index_mcp_flexion", 39.0),
            ("index_pip_flexion", 46.0),
            ("index_dip_flexion", 24.0),
            ("middle_mcp_abduction", -2.0),
            ("middle_mcp_flexion", 43.0),
            ("middle_pip_flexion", 55.0),
            ("middle_dip_flexion", 22.0),
        ],
    ),
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let hand = Hand::human();
    let skin = hand.skin();
    let (mut images, mut captions) = (Vec::new(), Vec::new());
    let distal = hand.palm.distal;
    let thumb_side = distal.cross(&hand.palm.volar);
    for (side, toward_eye) in [("palm", hand.palm.volar), ("thumb side", thumb_side)] {
        for (name, angles) in POSES {
            let mut x = hand.rest_coordinates();
            for (joint, degrees) in angles {
                match hand.joint(joint) {
                    Some(j) => x[7 + j] = degrees.to_radians(),
                    None => landscape::space::joints_of_mut(&mut x).fill(degrees.to_radians()),
                }
            }
            let mut posed = PosedHand::default();
            hand.pose(&x, &mut posed);
            let scene = Scene {
                surfaces: vec![Surface::of_hand(&skin, &posed)],
                ..Scene::default()
            };
            // The view is slightly from above, to show depth.
            let camera = scene.framed(toward_eye + distal * 0.25, distal);
            images.push(scene.render(&camera, 420, 460));
            captions.push(format!("{name}, {side}"));
        }
    }
    contact_sheet(
        &images,
        &captions,
        POSES.len(),
        "figures/hand_poses.png".as_ref(),
    )?;
    Ok(())
}
