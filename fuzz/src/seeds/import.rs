//! Small plant files as text.

use super::named;

/// A trunk of four sides with leaves by object, by form, and by material, in the ways to write them.
pub(super) fn obj() -> Vec<(String, Vec<u8>)> {
    named(&[
        (
            "objects",
            "# a tree\nmtllib t.mtl\no trunk\nv 0.1 0 0.1\nv 0.1 0 -0.1\nv -0.1 0 -0.1\nv -0.1 0 0.1\n\
             v 0.1 4 0.1\nv 0.1 4 -0.1\nv -0.1 4 -0.1\nv -0.1 4 0.1\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\n\
             f 4 1 5 8\no leaf\nv 1 2 0\nv 2 2 0\nv 2 3 0\nv 1 3 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
             usemtl leaf\nf -4/1 -3/2 -2/3 -1/4\nf 10/2 9/1 12/4 11/3\n",
        ),
        (
            "forms",
            "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 1 2 1\nv 0 2 1\ng a b\nf 1 2 3 4\nf 4 3 5 6\n\
             v 5 0 0\nv 6 0 0\nv 6 1 0\nv 5 1 0\nf 7 8 9 10\nv 8 0 0\nv 9 0 0\nv 9 1 0\nv 8 1 0\n\
             f 11 12 13 14\nv 15 0 0\nv 16 0 0\nv 16 1 0\nf 15 16 17\n",
        ),
        (
            "corners",
            "\u{feff}v 400000.25 5000000 300 1\r\nv 400001 5000000 300 1 0 0\r\nv 400001 5000000 \\\r\n 301\r\n\
             vn 0 0 1\nvn 0 0 0\nf 1//1 2//2 3\ns off\nl 1 2\np 1\ncurv 0 1\n",
        ),
    ])
}

/// Internodes that follow as children and as siblings, a leaf, and a nested axis.
pub(super) fn opf() -> Vec<(String, Vec<u8>)> {
    let tables = "<meshBDD><mesh Id=\"0\" enableScale=\"true\"><points>0 .5 0 0 0 .5 0 -.5 0 1 .5 0 1 0 .5 1 -.5 0\
        </points><faces><face>0 1 4 3</face></faces></mesh><mesh Id=\"1\"><points>0 0 0 1 0 0 1 1 0 0 1 0</points>\
        <textureCoords>0 0 1 0 1 1 0 1</textureCoords><faces><face>0 1 2 3</face></faces></mesh></meshBDD>\
        <materialBDD><material Id=\"0\"><diffuse>.5 .4 .2 1</diffuse></material></materialBDD><shapeBDD>\
        <shape Id=\"0\"><name>stem</name><meshIndex>0</meshIndex><materialIndex>0</materialIndex></shape>\
        <shape Id=\"1\"><name>leaf</name><meshIndex>1</meshIndex></shape></shapeBDD>";
    let geometry = |shape: u32, height: u32| {
        format!(
            "<geometry><shapeIndex>{shape}</shapeIndex><mat>0 0 -1 0 0 1 0 0 100 0 0 {height}</mat>\
             <dUp>8</dUp><dDwn>10</dDwn></geometry>"
        )
    };
    let (stem, next, leaf) = (geometry(0, 0), geometry(0, 100), geometry(1, 100));
    let document = |topology: &str| {
        format!("<opf version=\"2.0\">{tables}<topology scale=\"0\">{topology}</topology></opf>")
    };
    let nested = document(&format!(
        "<decomp class=\"I\" scale=\"3\"><Length>1</Length>{stem}<follow class=\"I\" scale=\"3\">{next}\
         <branch class=\"leaf\" scale=\"3\">{leaf}</branch></follow></decomp>"
    ));
    let siblings = document(&format!(
        "<decomp class=\"Axis\" scale=\"2\"><decomp class=\"I\" scale=\"3\">{stem}</decomp>\
         <follow class=\"I\" scale=\"3\">{next}</follow></decomp><branch class=\"Axis\" scale=\"2\">\
         <decomp class=\"I\" scale=\"3\">{next}</decomp></branch>"
    ));
    named(&[
        ("nested", &nested),
        ("siblings", &siblings),
        ("empty", &document("")),
    ])
}

/// Parameters of every kind.
pub(super) fn arbaro() -> Vec<(String, Vec<u8>)> {
    let document = |params: &str| {
        let params: String = params
            .split_whitespace()
            .filter_map(|param| param.split_once('='))
            .map(|(name, value)| format!("<param name='{name}' value='{value}'/>\n"))
            .collect();
        format!("<?xml version='1.0' ?>\n<arbaro>\n<species name='tree'>\n<!-- all -->\n{params}</species>\n</arbaro>\n")
    };
    let small = document("Shape=3 Levels=2 Scale=2 Leaves=5 1Branches=4 LeafShape=disc2 1BranchDist=0");
    let needles = document("Shape=0 Levels=2 Scale=2 ScaleV=1 Leaves=-5 LeafShape=sphere LeafScaleX=0.02 0BaseSplits=2");
    let beyond = document("Levels=9 RatioPower=-1 Flare=-1 1CurveV=-90 2RotateV=-20 LeafQuality=0.5 Smooth=1 Other=1");
    named(&[
        ("small", &small),
        ("needles", &needles),
        ("beyond", &beyond),
    ])
}
