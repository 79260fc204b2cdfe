//! Every shipped mutant is caught by the law that it is meant for, and no sound model by any.

use spinney::testkit::{Law, MutantReport, selftest};

#[test]
fn every_mutant_is_caught_by_its_law_and_nothing_else_is() {
    let report = selftest();
    let alarms: Vec<&MutantReport> = report.false_alarms().collect();
    assert!(alarms.is_empty(), "{alarms:#?}");
    let wanted = [
        ("literal list", Law::BirthBeforeDeath),
        ("literal next", Law::BirthBeforeDeath),
        ("n_split with plus", Law::HistoryIndependence),
        ("split reads next entry", Law::SplitUndoesCollapse),
        ("group loop runs on", Law::Partition),
        ("cursor not resynchronised", Law::HistoryIndependence),
        ("leaf count not updated", Law::HistoryIndependence),
        ("wrong birth", Law::Partition),
        ("stored by depth", Law::BirthBeforeDeath),
        ("old2 for old1", Law::Partition),
        ("init moves by one", Law::BirthBeforeDeath),
        ("leaf count to nearest", Law::MonotoneDetail),
        ("leaf count not clamped", Law::MonotoneDetail),
        ("stale slot on split", Law::Residency),
        ("missed dirty range", Law::Residency),
        ("count not sent", Law::Residency),
        ("wrong offset", Law::Residency),
        ("threshold not sent", Law::Residency),
        ("one collapse too far", Law::Residency),
        ("wrong birth stamp", Law::ImageEquality),
        ("transfer not counted", Law::Conservation),
        ("transfer counted twice", Law::Conservation),
        ("byte behind the bus", Law::Conservation),
        ("draw stops short", Law::ImageEquality),
        ("ties by slot order", Law::ImageEquality),
        ("literal eigen-solver", Law::ErrorNeverRises),
    ];
    let caught = |mutant: &MutantReport| (mutant.name.clone(), mutant.caught_by());
    let caught: Vec<_> = report.mutants.iter().map(caught).collect();
    let wanted = wanted.map(|(name, law)| (name.to_owned(), Some(law)));
    assert_eq!(caught, wanted);
    assert!(report.is_passed());
    for law in Law::ALL {
        assert!(report.tally.checked(law) > 1000, "{law}");
    }
    // One that nothing catches, or one that is caught and sound, fails the whole.
    let mut escaped = report.clone();
    escaped.mutants[0].counterexample = None;
    assert!(!escaped.is_passed());
    let mut alarmed = report.clone();
    alarmed.sound[0].counterexample = report.mutants[0].counterexample.clone();
    assert!(!alarmed.is_passed());
}
