use super::super::triangles::examples::squares;
use super::*;
use crate::plant::Foliage;

const FRONT: ViewFrame = ViewFrame {
    origin: Vec3::ZERO,
    right: Vec3::X,
    up: Vec3::Y,
    toward: Vec3::Z,
};

fn view(frame: ViewFrame, sites: BakeSites) -> BakeView {
    BakeView {
        sites,
        frame,
        rectangle: Rectangle {
            least: Vec2::new(-2.0, -2.0),
            greatest: Vec2::new(2.0, 2.0),
        },
        size: [4, 4],
    }
}

/// A red leaf in front of a green one, both facing +Z, and a blue one beside them.
///
/// ```text
///  y 2 ┌───────┐     red:   (−1, 1) to (1, 2), at z = 1
///      │ r r   │     green: (−1, 0) to (1, 2), at z = 0
///      │ g g   │     blue:  (0, −2) to (2, 0), at z = −1
///      │   b b │
///      │   b b │
///   −2 └───────┘ x from −2 to 2, shifted by 1
/// ```
fn leaves() -> LeafTriangles {
    let mut red = squares([1.0, 0.0, 0.0], &[(Vec3::new(0.0, 1.5, 1.0), 2.0)]);
    for corner in &mut red.positions {
        corner.y = corner.y.clamp(1.0, 2.0);
    }
    let green = squares([0.0, 1.0, 0.0], &[(Vec3::new(0.0, 1.0, 0.0), 2.0)]);
    let blue = squares([0.0, 0.0, 1.0], &[(Vec3::new(1.0, -1.0, -1.0), 2.0)]);
    LeafTriangles::of(&Foliage {
        groups: vec![red, green, blue],
    })
}

fn picture(view: &BakedView) -> String {
    let rows = view.colour.chunks(4 * view.size[0] as usize);
    let rows = rows.map(|row| {
        let letter = |texel: &[u8; 4]| match texel {
            [255, 0, 0, 255] => 'r',
            [0, 255, 0, 255] => 'g',
            [0, 0, 255, 255] => 'b',
            [0, 0, 0, 0] => '.',
            _ => '?',
        };
        row.as_chunks::<4>()
            .0
            .iter()
            .map(letter)
            .collect::<String>()
    });
    rows.collect::<Vec<_>>().join(" ")
}

#[test]
fn leaves_hide_one_another_from_either_side() {
    let leaves = leaves();
    let views = [
        view(FRONT, BakeSites::All),
        view(FRONT.behind(), BakeSites::All),
        view(FRONT, BakeSites::Listed(vec![1, 2])),
        view(FRONT, BakeSites::Listed(Vec::new())),
    ];
    for supersampling in [1, 2, 3] {
        let baked = bake(&leaves, &views, BakeOptions { supersampling }).expect("small");
        let pictures: Vec<String> = baked.views.iter().map(picture).collect();
        let wanted = [
            ".rr. .gg. ..bb ..bb",
            ".gg. .gg. ..bb ..bb",
            ".gg. .gg. ..bb ..bb",
            ".... .... .... ....",
        ];
        assert_eq!(pictures, wanted);
        let [front, behind, ..] = &baked.views[..] else {
            panic!("four views");
        };
        // Red is the nearest from in front, blue from behind; normals are turned to the viewer.
        let of =
            |view: &BakedView, x: usize, y: usize| view.normals[4 * (4 * y + x)..][..4].to_vec();
        assert_eq!(of(front, 1, 0), [128, 128, 255, 255]);
        assert_eq!(of(front, 3, 3), [128, 128, 255, 0]);
        assert_eq!(of(behind, 1, 0), [128, 128, 0, 128]);
        assert_eq!(of(behind, 3, 3), [128, 128, 0, 255]);
        let [farthest, nearest] = front.depths;
        assert!(farthest < -1.0 && nearest > 1.0 && nearest - farthest < 2.01);
        assert_eq!(baked.ledger.draws, 3 + 3 + 2);
    }
}

#[test]
fn a_view_ends_at_its_rectangle_and_sheets_do_not_mix() {
    let leaves = leaves();
    let mut views = vec![view(FRONT, BakeSites::All); 3];
    views[0].rectangle.greatest = Vec2::new(0.0, 2.0);
    views[0].size = [2, 4];
    views[1].size = [8, 8];
    let options = BakeOptions { supersampling: 1 };
    let baked = bake(&leaves, &views, options).expect("small");
    assert_eq!(picture(&baked.views[0]), ".r .g .. ..");
    assert_eq!(
        picture(&baked.views[1]),
        "..rrrr.. ..rrrr.. ..gggg.. ..gggg.. ....bbbb ....bbbb ....bbbb ....bbbb"
    );
    assert_eq!(picture(&baked.views[2]), ".rr. .gg. ..bb ..bb");
    // Two do not fit beside each other: each lies on a sheet of its own.
    let mut wide = vec![view(FRONT, BakeSites::All); 2];
    wide.iter_mut().for_each(|view| view.size = [2048, 4]);
    let baked = bake_on_sheets(&leaves, &wide, options, 8192).expect("within a target");
    assert_eq!(baked.views[0], baked.views[1]);
    assert_eq!(baked.views[0].colour[4 * 512..][..4], [255, 0, 0, 255]);
}

#[test]
fn a_rectangle_is_around_points_and_has_sides() {
    let points = [Vec3::new(1.0, 2.0, 7.0), Vec3::new(3.0, 2.0, -7.0)];
    let rectangle = Rectangle::around(&FRONT, points.into_iter());
    assert_eq!(rectangle.sides().x, 2.0);
    assert!(rectangle.sides().y > 0.0);
    assert_eq!(rectangle.at(Vec2::new(0.0, 0.5)), Vec2::new(1.0, 2.0));
    assert!(Rectangle::around(&FRONT, std::iter::empty()).sides().x > 0.0);
    let point = Vec3::new(0.3, -4.0, 2.5);
    let behind = FRONT.behind();
    assert_eq!(
        behind.point(behind.seen(point), behind.offset(point)),
        point
    );
}
