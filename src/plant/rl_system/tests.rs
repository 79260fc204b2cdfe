//! Grammars: what they say, what they grow, and where they are wrong.

use std::path::Path;

use super::*;
use crate::math::{Vec3, det};
use crate::plant::SpeciesFile;

fn document(rules: &str) -> Document {
    Document {
        file: "small.rls".to_owned(),
        text: format!(
            "schema \"spinney.rls/1\" name \"small\" steps 4 leaf x {{ width 0.5 }}\n{rules}"
        ),
    }
}

fn grown(rules: &str, seed: u64) -> Growth {
    let system = RlSystem::parse(&document(rules)).expect("the test's own text");
    system.grow(seed).expect("a small plant")
}

fn refused(rules: &str) -> String {
    match RlSystem::parse(&document(rules)) {
        Err(error) => error.to_string(),
        Ok(system) => system.grow(1).expect_err("it should not grow").to_string(),
    }
}

fn shipped(name: &str) -> RlSystem {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/species");
    let document = Document::read(&folder.join(name)).expect("shipped");
    RlSystem::parse(&document).expect("shipped grammars are sound")
}

#[test]
fn the_ternary_tree_has_the_papers_branches_and_leaves() {
    let system = shipped("ternary.rls");
    for seed in 1..=2 {
        let Growth { plant, placed } = system.grow(seed).expect("it grows");
        let skeleton = plant.skeleton().expect("it has branches");
        assert_eq!(skeleton.branches.len(), 9841);
        assert_eq!((plant.foliage().quad_count(), placed.len()), (8748, 8748));
        let on_level = |level: u32| {
            let branches = skeleton.branches.iter();
            branches.filter(|branch| branch.level == level).count()
        };
        for level in 0..=8 {
            assert_eq!(on_level(level), 3_usize.pow(level));
        }
        for leaf in &placed {
            let level = skeleton.branches[leaf.branch as usize].level;
            assert!(level >= 7, "a leaf on level {level}");
        }
        assert_eq!(
            system.grow(seed).expect("it grows").plant.digest(),
            plant.digest()
        );
    }
    let [first, second] = [1, 2].map(|seed| system.grow(seed).expect("it grows").plant.digest());
    assert_ne!(first, second, "seeds differ");
}

#[test]
fn the_other_species_bear_what_they_should() {
    let apple = shipped("apple.rls");
    let growth = apple.grow(1).expect("it grows");
    let kinds = |name: &str| {
        let groups = growth.plant.foliage().groups.iter();
        groups
            .filter(|group| group.name == name)
            .map(|group| group.leaf_count())
            .sum::<usize>()
    };
    let counts = ["leaf", "apple", "blossom"].map(kinds);
    assert!(
        counts[0] > 2000 && counts[1] > 20 && counts[2] > 0,
        "{counts:?}"
    );
    let strokes = apple.strokes(&growth).count();
    assert_eq!(strokes, counts[0] + 3 * counts[1] + 5 * counts[2]);
    let spruce = shipped("spruce.rls").grow(1).expect("it grows");
    assert!(
        spruce.plant.foliage().quad_count() > 1500,
        "{}",
        spruce.plant.foliage().quad_count()
    );
    let size = spruce.plant.bounds().size();
    assert!(size.y > 4.0 && size.y > size.x, "{size}");
}

/// ```text
///   ●          a leaf at (0, 3, 0), and one at the tip of the
///   │  ╱ ●     branch that leaves at (0, 1, 0) by 45 degrees
///   ├─╱
///   │
/// ```
#[test]
fn the_turtle_draws_branches_of_pieces_and_returns() {
    let Growth { plant, placed } = grown("axiom F(1, 0.02) [ +(45) F(2) ~x(1) ] F(2) ~x(0.5)", 1);
    let skeleton = plant.skeleton().expect("two branches");
    let levels: Vec<(u32, u32, Option<u32>)> = skeleton
        .branches
        .iter()
        .map(|branch| (branch.level, branch.node_count, branch.bearer))
        .collect();
    assert_eq!(levels, [(0, 3, None), (1, 2, Some(1))]);
    let places = [0, 1, 2].map(|node: usize| skeleton.nodes[node].position);
    assert_eq!(places, [0.0, 1.0, 3.0].map(|y| y * Vec3::Y));
    assert_eq!(skeleton.nodes[1].radius.to_bits(), 0.02_f32.to_bits());
    let side = 2.0 * det::sin(45_f32.to_radians());
    assert!(
        (placed[0].base - Vec3::new(-side, 1.0 + side, 0.0)).length() < 1e-5,
        "{}",
        placed[0].base
    );
    assert_eq!((placed[1].base, placed[1].branch), (3.0 * Vec3::Y, 0));
    let group = &plant.foliage().groups[0];
    let tip = 0.5 * (group.leaf(1)[2] + group.leaf(1)[3]);
    assert!(
        (tip - 3.5 * Vec3::Y).length() < 1e-6,
        "the leaf is half a metre long"
    );
    assert_eq!(group.owners, [1, 0]);
}

#[test]
fn conditions_and_weights_choose_and_random_numbers_belong_to_their_module() {
    let counted = |rules: &str| grown(rules, 1).placed.len();
    assert_eq!(
        counted("let n = 2 * (1 + 0.5) axiom A(n) rule A(i): i > 0 -> ~x(1) A(i - 1)"),
        3
    );
    assert_eq!(
        counted("axiom A(9) rule A(i): not (i == 0) -> ~x(1) A(i - 1)"),
        4,
        "steps end it"
    );
    assert_eq!(
        counted("axiom A rule A @ 0 -> ~x(1) rule A @ 1 -> ~x(1) ~x(1)"),
        2
    );
    let many = "axiom A(1) A(2) A(3) A(4) A(5) A(6) A(7) A(8) A(9) rule A(i) @ 3 -> ~x(rnd(1, 2)) \
                rule A(i) @ 1 -> f(1)";
    let kept = |seed| grown(many, seed).placed.len();
    let sum: usize = (0..200).map(kept).sum();
    assert!((1250..1450).contains(&sum), "three quarters of 1800: {sum}");
    // One more random number before changes no other module's.
    let [plain, more] = ["f(1)", "f(rnd(1, 1))"].map(|first| {
        let rules = format!("axiom {first} A rule A -> ~x(rnd(1, 2)) ~x(nrm(5, 1))");
        grown(&rules, 7)
            .placed
            .iter()
            .map(|leaf| leaf.size.to_bits())
            .collect::<Vec<_>>()
    });
    assert_eq!(plain, more);
}

#[test]
fn errors_name_the_place_and_the_way_out() {
    for (rules, wanted) in [
        (
            "axiom A",
            "small.rls:2:7: A has no rule and is no command (F, f, T), wanted a rule for it",
        ),
        (
            "axiom F(1",
            "small.rls:2:10: the end of the file found, wanted \")\"",
        ),
        (
            "axiom [ F(1)",
            "small.rls:2:7: a [ that is not closed, wanted a ]",
        ),
        ("axiom F(1) ]", "small.rls:2:12: a ] without its ["),
        (
            "axiom F",
            "small.rls:2:7: \"F\" has 0 numbers in parentheses, wanted 1 or 2",
        ),
        (
            "axiom ~y(1)",
            "small.rls:2:8: ~y is declared nowhere above, wanted one of: x",
        ),
        (
            "axiom F(y)",
            "small.rls:2:9: y is no parameter of this rule",
        ),
        (
            "axiom A(1) rule A(x) -> f(x) rule A -> f(1)",
            "small.rls:2:35: A has 0 parameters here, wanted 1",
        ),
        (
            "let a = rnd(1, 2) axiom f(a)",
            "small.rls:2:5: let a is random",
        ),
        (
            "steps 0",
            "small.rls:2:7: 0 found, wanted steps as a whole number from 1 to 1000",
        ),
        (
            "leaf y { petals 3 }",
            "small.rls:2:10: petals is no key here, wanted color, width and silhouette",
        ),
        (
            "leaf y { silhouette \"oak\" }",
            "small.rls:2:21: silhouette is \"oak\", wanted one of ovate_serrate",
        ),
        ("axiom f(1.2.3)", "small.rls:2:9: \"1.2.3\" is no number"),
        ("name \"open", "small.rls:2:6: a text without its end"),
        (
            "axiom \u{20ac}",
            "small.rls:2:7: '\u{20ac}' means nothing here",
        ),
        ("", "small.rls:2:1: the file ends without axiom"),
        ("axiom F(0/0)", "small.rls:2:7: a step of NaN"),
        ("axiom !(0 - 1)", "small.rls:2:7: a radius of -1"),
        ("axiom ~x(0)", "small.rls:2:7: a size of 0"),
        ("axiom +(1/0)", "small.rls:2:7: a turn by inf degrees"),
    ] {
        let found = refused(rules);
        assert!(
            found.starts_with(wanted),
            "{rules}\nfound  {found}\nwanted {wanted}"
        );
    }
}

#[test]
fn growth_is_bounded() {
    let wide = "steps 1000 axiom A rule A -> A A";
    let found = refused(wide);
    assert!(found.contains("33554432 steps of work"), "{found}");
    let brackets = refused(&format!(
        "axiom {} {}",
        "[".repeat(70_000),
        "]".repeat(70_000)
    ));
    assert!(brackets.contains("65536"), "{brackets}");
    let nested = refused(&format!("axiom f({}1{})", "(".repeat(100), ")".repeat(100)));
    assert!(nested.contains("nested more than 64"), "{nested}");
    let minuses = refused(&format!("axiom f({}1)", "-".repeat(100)));
    assert!(minuses.contains("nested more than 64"), "{minuses}");
}

#[test]
fn a_file_is_a_grammar_by_its_ending() {
    let found = SpeciesFile::parse(&document("axiom ~x(1)")).expect("a grammar");
    assert!(matches!(&found, SpeciesFile::RlSystem(system) if system.name() == "small"));
    assert_eq!(found.grow(1).expect("a leaf").foliage().leaf_count(), 1);
    assert_eq!(SpeciesFile::ending_of("a/B.RLS"), "rls");
    assert_eq!(SpeciesFile::ending_of("rls"), "toml");
}
