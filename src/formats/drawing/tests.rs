//! Lines of small drawings against what their specifications say.

use super::*;
use crate::{Format, Place, ReadError};

fn svg(body: &str) -> Vec<DrawnLine> {
    read_svg(format!("<svg xmlns='http://www.w3.org/2000/svg'>{body}</svg>").as_bytes()).unwrap()
}

fn at([a, b, c, d]: [PlaceMm; 4], t: f64) -> PlaceMm {
    let s = 1.0 - t;
    std::array::from_fn(|axis| {
        s * s * s * a[axis]
            + 3.0 * s * s * t * b[axis]
            + 3.0 * s * t * t * c[axis]
            + t * t * t * d[axis]
    })
}

fn corners(line: &DrawnLine) -> Vec<PlaceMm> {
    let mut places = vec![line.pieces[0][0]];
    places.extend(line.pieces.iter().map(|piece| piece[3]));
    places
}

/// Every piece begins where the one before ended, and a closed line ends where it begins.
fn hangs_together(line: &DrawnLine) {
    assert!(line.pieces.windows(2).all(|pair| pair[0][3] == pair[1][0]), "{line:?}");
    assert!(!line.closed || line.pieces.last().unwrap()[3] == line.pieces[0][0], "{line:?}");
}

fn on_circle(line: &DrawnLine, centre: PlaceMm, radius: f64) {
    hangs_together(line);
    for piece in &line.pieces {
        for step in 0..=20 {
            let [x, y] = at(*piece, f64::from(step) / 20.0);
            let off = (x - centre[0]).hypot(y - centre[1]) - radius;
            assert!(off.abs() < 2e-9 * radius, "{off}");
        }
    }
}

#[test]
fn commands_of_paths_in_full_and_relative() {
    let lines = svg("<path d='M10-5 20,5l.5.5H3v2zm1 1 1 0M0 0'/>");
    assert_eq!(
        corners(&lines[0]),
        [[10.0, 5.0], [20.0, -5.0], [20.5, -5.5], [3.0, -5.5], [3.0, -7.5], [10.0, 5.0]]
    );
    assert!(lines[0].closed && !lines[1].closed);
    assert_eq!(corners(&lines[1]), [[11.0, 4.0], [12.0, 4.0]]);
    assert_eq!(lines.len(), 2);
    let [c, s, q, t] = [
        "M0 0C1 1 2 1 3 0S5-1 6 0",
        "M0 0C1 1 2 1 3 0C4 -1 5 -1 6 0",
        "M0 0Q1 2 2 0T4 0",
        "M0 0Q1 2 2 0Q3 -2 4 0",
    ]
    .map(|data| svg(&format!("<path d='{data}'/>")));
    assert_eq!((c, q), (s, t));
    // A quadratic curve has its middle half way to its control point.
    let quadratic = svg("<path d='M0 0q1 2 2 0'/>");
    assert_eq!(
        at(quadratic[0].pieces[0], 0.5).map(|value| (value * 1e12).round() / 1e12),
        [1.0, -1.0]
    );
}

#[test]
fn arcs_are_arcs() {
    // Flags may stand without anything between.
    let half = svg("<path d='M-5 0a5 5 0 0110 0'/>");
    on_circle(&half[0], [0.0, 0.0], 5.0);
    // With the sweep flag the arc goes clockwise on the picture, so above the line.
    assert!(at(half[0].pieces[4], 0.5)[1] > 0.0);
    let large = svg("<path d='M0 0A5 5 0 1 0 5 5'/>");
    on_circle(&large[0], [0.0, -5.0], 5.0);
    assert_eq!(large[0].pieces.len(), 24);
    // A radius too small is made to fit.
    on_circle(&svg("<path d='M0 0A1 1 0 0 0 8 0'/>")[0], [4.0, 0.0], 4.0);
    let ellipse = svg("<ellipse cx='1' cy='2' rx='3' ry='0.5'/>");
    hangs_together(&ellipse[0]);
    for piece in &ellipse[0].pieces {
        let [x, y] = at(*piece, 0.3);
        assert!((((x - 1.0) / 3.0).powi(2) + ((y + 2.0) / 0.5).powi(2) - 1.0).abs() < 1e-8);
    }
    on_circle(&svg("<circle cx='-3' cy='4' r='2'/>")[0], [-3.0, -4.0], 2.0);
}

#[test]
fn shapes_transforms_and_what_is_not_drawn() {
    let lines = svg("<defs><path d='M0 0L1 1'/></defs><g transform='translate(10 0) scale(2)'>\
         <rect x='1' y='1' width='2' height='1'/><polyline points='0,0 1,0 1,1' transform='rotate(90)'/></g>\
         <polygon points='0 0 4 0 4 4'/><line x1='1' y1='2' x2='3' y2='4'/><text>no</text>");
    assert_eq!(lines.len(), 4);
    assert_eq!(
        corners(&lines[0]),
        [[12.0, -2.0], [16.0, -2.0], [16.0, -4.0], [12.0, -4.0], [12.0, -2.0]]
    );
    let turned = corners(&lines[1]);
    assert!((turned[1][0] - 10.0).abs() < 1e-12 && (turned[1][1] + 2.0).abs() < 1e-12);
    assert!(lines[0].closed && !lines[1].closed && lines[2].closed && !lines[3].closed);
    let round = svg("<rect width='4' height='2' rx='1'/>");
    hangs_together(&round[0]);
    assert_eq!(round[0].pieces.len(), 4 * 8 + 2);
}

#[test]
fn units_come_from_the_root() {
    let scaled = |root: &str| {
        let text = format!("<svg {root}><path d='M0 0L10 0'/></svg>");
        corners(&read_svg(text.as_bytes()).unwrap()[0])[1][0]
    };
    assert_eq!(scaled("width='50mm' height='50mm' viewBox='0 0 100 100'"), 5.0);
    assert!((scaled("width='1in' viewBox='0 0 127 127'") - 2.0).abs() < 1e-12);
    assert_eq!(scaled("width='100' viewBox='0 0 50 50'"), 10.0);
    assert_eq!(scaled("width='96px'"), 10.0);
    assert!((scaled("width='10mm'") - 2.645_833_333_333_333).abs() < 1e-12);
}

#[test]
fn what_is_not_understood_is_refused_with_its_place() {
    let refused = |text: &str| read_svg(text.as_bytes()).unwrap_err().to_string();
    assert!(
        refused("<svg><path d='M0 0L1 x'/></svg>").contains("element path: expected path data")
    );
    assert!(refused("<svg><path d='0 0'/></svg>").contains("path data"));
    assert!(refused("<svg><g transform='turn(3)'/></svg>").contains("a transform"));
    assert!(refused("<svg><circle r='wide'/></svg>").contains("a number as r"));
    assert!(refused("<html/>").contains("an element svg"));
    assert!(refused("<svg><g></svg>").contains("well-formed XML"));
    assert!(read_svg(b"<svg/>").unwrap().is_empty());
}

#[test]
fn shapes_that_are_not_shown_are_counted() {
    let read = |body: &str| read_svg_and_count(format!("<svg>{body}</svg>").as_bytes()).unwrap();
    let hidden = |body: &str| {
        let (lines, left_out) = read(&format!("<path d='M0 0L1 0'/>{body}"));
        let count = left_out.get("circle not shown").copied();
        lines.len() == 1 && count == Some(1) && left_out.len() == 1
    };
    let with = |attributes: &str| format!("<circle r='5' {attributes}/>");
    assert!(hidden(&with("display='none'")));
    assert!(hidden(&with("style='fill:red; Display : NONE !important'")));
    assert!(hidden(&with("visibility='hidden'")) && hidden(&with("style='visibility:collapse'")));
    assert!(hidden(&format!("<g style='display:none'><g display='inline'>{}</g></g>", with(""))));
    // The rules stand behind the shape, in a comment and a section of characters.
    let sheet = |rules: &str, attributes: &str| {
        format!("{}<style><![CDATA[ @import 'a.css'; {rules} ]]></style>", with(attributes))
    };
    let ways = [".h", "circle", "*.h", "#c", "rect, circle.h", ".h.k#c"];
    for way in ways {
        let rules = format!("/* a {{}} */ {way} {{ fill: none; display: none }}");
        assert!(hidden(&sheet(&rules, "class='k h' id='c'")), "{way}");
        let shown = sheet(&rules, "class='k h' id='c' style='display:inline'");
        assert_eq!(read(&shown).1.len(), 0, "{way}");
    }
    for (rules, attributes) in [
        (".h{display:none}", "class='hh'"),
        (".h{visibility:visible}", "class='h' visibility='hidden'"),
        ("#c{display:block} .h{display:none}", "class='h' id='c'"),
        (".h{display:none} .h{display:block}", "class='h'"),
        (".h{display:block !important}", "class='h' style='display:none'"),
        ("g .h{fill:red} @font-face{src:url(a)}", "class='h'"),
    ] {
        let (lines, left_out) = read(&sheet(rules, attributes));
        assert_eq!((lines.len(), left_out.len()), (1, 0), "{rules}");
    }
    // A child of what is not visible may be; a child of what is not displayed never is. Texts that are not shown are nothing.
    let child = "<circle r='5' visibility='visible'/><text>a</text>";
    let (lines, left_out) = read(&format!("<g visibility='hidden'>{child}<rect/></g>"));
    assert_eq!((lines.len(), left_out.len(), left_out["rect not shown"]), (1, 1, 1));
    assert!(hidden(&format!("<g display='none'>{child}</g>")));
    let refused = |rules: &str| {
        read_svg(format!("<svg>{}</svg>", sheet(rules, "")).as_bytes()).unwrap_err().to_string()
    };
    let said = refused("g > .h { display: none }");
    assert_eq!(
        said,
        "SVG file, element style: \"g > .h\" is not supported, expected a name, a class or an id that sets display or visibility"
    );
    assert!(refused("@media print { .h { display: none } }").contains("\"@media print\""));
}

/// SVG 2, 8.2: a viewport within another has a place, and its view box a scale.
#[test]
fn drawings_within_drawings_lie_in_their_viewports() {
    let place = |attributes: &str| {
        let text =
            format!("<svg x='7' y='7'><svg {attributes}><path d='M10 20L30 20'/></svg></svg>");
        read_svg(text.as_bytes()).map(|lines| corners(&lines[0])).map_err(|error| error.to_string())
    };
    assert_eq!(place("x='100' y='5px'").unwrap(), [[110.0, -25.0], [130.0, -25.0]]);
    assert_eq!(
        place("x='100' transform='scale(2)' width='9'").unwrap(),
        [[220.0, -40.0], [260.0, -40.0]]
    );
    // 20 × 20 units in a viewport of 80 × 40: twice as large, and 20 right; or 4 and 2 times as large.
    let boxed = "x='100' width='80' height='40' viewBox='10 20 20,20' preserveAspectRatio=";
    for (ratio, expected) in [
        ("xMidYMid meet", [[120.0, 0.0], [160.0, 0.0]]),
        ("xMinYMid", [[100.0, 0.0], [140.0, 0.0]]),
        ("xMaxYMax", [[140.0, 0.0], [180.0, 0.0]]),
        ("xMidYMid slice", [[100.0, 20.0], [180.0, 20.0]]),
        ("none", [[100.0, 0.0], [180.0, 0.0]]),
    ] {
        assert_eq!(place(&format!("{boxed}'{ratio}'")).unwrap(), expected, "{ratio}");
    }
    assert!(place(&format!("{boxed}'left'")).unwrap_err().contains("a preserveAspectRatio"));
    assert!(
        place("viewBox='0 0 1 1'").unwrap_err().contains("element svg: expected width and height")
    );
    assert!(
        place("width='50%' height='1' viewBox='0 0 1 1'")
            .unwrap_err()
            .contains("a number as width")
    );
}

/// The text of a DXF file with entities.
fn dxf(entities: &str) -> Vec<u8> {
    let text = format!("0\nSECTION\n2\nENTITIES\n{entities}0\nENDSEC\n0\nEOF\n");
    text.replace(';', "\n").into_bytes()
}

#[test]
fn entities_of_dxf() {
    let square = dxf("0;LWPOLYLINE;90;4;70;1;10;0;20;0;10;2;20;0;10;2;20;2;10;0;20;2;");
    let lines = read_dxf(&square).unwrap();
    assert_eq!(corners(&lines[0]), [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0], [0.0, 0.0]]);
    assert!(lines[0].closed);
    // Two half circles by bulges are a circle; the first runs counter-clockwise below.
    let round =
        dxf("0;POLYLINE;66;1;70;1;0;VERTEX;10;-1;20;0;42;1;0;VERTEX;10;1;20;0;42;1;0;SEQEND;");
    let lines = read_dxf(&round).unwrap();
    on_circle(&lines[0], [0.0, 0.0], 1.0);
    assert!(at(lines[0].pieces[8], 0.0)[1] < -0.999);
    let quarter = read_dxf(&dxf("0;ARC;10;1;20;1;40;2;50;0;51;90;")).unwrap();
    on_circle(&quarter[0], [1.0, 1.0], 2.0);
    on_circle(&read_dxf(&dxf("0;CIRCLE;10;1;20;1;40;2;")).unwrap()[0], [1.0, 1.0], 2.0);
    // Lines in any direction are joined to one that closes.
    let joined = dxf(
        "0;LINE;10;0;20;0;11;1;21;0;0;LINE;10;1;20;1;11;1;21;0;0;TEXT;1;hello;0;LINE;10;1;20;1;11;0;21;0;",
    );
    let lines = read_dxf(&joined).unwrap();
    assert!(lines.len() == 1 && lines[0].closed);
    assert_eq!(corners(&lines[0]), [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 0.0]]);
    hangs_together(&lines[0]);
}

#[test]
fn dxf_units_and_mistakes() {
    let header = b"0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n1\n0\nENDSEC\n".to_vec();
    let inch = [header, dxf("0;LINE;10;0;20;0;11;1;21;0;")].concat();
    assert_eq!(corners(&read_dxf(&inch).unwrap()[0])[1], [25.4, 0.0]);
    let spline = read_dxf(&dxf("0;SPLINE;70;8;")).unwrap_err();
    assert!(matches!(
        spline,
        ReadError::Unsupported { format: Format::Dxf, place: Place::Line { line: 6, .. }, .. }
    ));
    let wrong = read_dxf(&dxf("0;LINE;10;wide;")).unwrap_err().to_string();
    assert!(wrong.contains("line 8") && wrong.contains("a number"), "{wrong}");
    assert!(read_dxf(b"0\nSECTION\n2\n").is_err());
    assert!(read_dxf(b"hello\nworld\n").is_err());
    assert!(read_dxf(b"AutoCAD Binary DXF\r\n").is_err());
}

/// Golden facts of AutoCAD's "arbitrary axis algorithm": of (0, 0, −1) the axes are (−1, 0, 0) and (0, 1, 0).
#[test]
fn mirrored_entities_of_dxf_lie_where_they_are() {
    const MIRRORED: &str = "210;0;220;0;230;-1;";
    let circle = dxf(&format!("0;CIRCLE;10;-30;20;4;40;2;{MIRRORED}"));
    on_circle(&read_dxf(&circle).unwrap()[0], [30.0, 4.0], 2.0);
    // From 0° to 90° about (−3, 0): on the drawing from (1, 0) up to (3, 2).
    let arc = dxf(&format!("0;ARC;10;-3;20;0;40;2;50;0;51;90;{MIRRORED}"));
    let line = &read_dxf(&arc).unwrap()[0];
    on_circle(line, [3.0, 0.0], 2.0);
    let [from, to] = [line.pieces[0][0], line.pieces.last().unwrap()[3]];
    assert!((from[0] - 1.0).hypot(from[1]) < 1e-12 && (to[0] - 3.0).hypot(to[1] - 2.0) < 1e-12);
    // A half circle from (−1, 0) to (−3, 0) that bulges up in its own coordinates and in those of the drawing.
    let bulged = "10;-1;20;0;42;1;10;-3;20;0;";
    let light = dxf(&format!("0;LWPOLYLINE;90;2;70;0;{MIRRORED}{bulged}"));
    let heavy = "0;VERTEX;10;-1;20;0;42;1;0;VERTEX;10;-3;20;0;0;SEQEND;";
    let heavy = dxf(&format!("0;POLYLINE;66;1;{MIRRORED}{heavy}"));
    for file in [light, heavy] {
        let line = &read_dxf(&file).unwrap()[0];
        on_circle(line, [2.0, 0.0], 1.0);
        assert_eq!((line.pieces[0][0], at(line.pieces[8], 0.0)[1] > 0.999), ([1.0, 0.0], true));
    }
    // A LINE, and a POLYLINE in space, have the coordinates of the drawing whatever their direction is.
    let line = dxf("0;LINE;10;1;20;2;11;3;21;4;210;0;220;1;230;0;");
    let space = "0;VERTEX;10;1;20;2;70;32;0;VERTEX;10;3;20;4;70;32;0;SEQEND;";
    let space = dxf(&format!("0;POLYLINE;70;8;{MIRRORED}{space}"));
    for file in [line, space] {
        assert_eq!(corners(&read_dxf(&file).unwrap()[0]), [[1.0, 2.0], [3.0, 4.0]]);
    }
    let plain = dxf("0;CIRCLE;10;-30;20;4;40;2;210;0;220;1e-17;230;1;");
    on_circle(&read_dxf(&plain).unwrap()[0], [-30.0, 4.0], 2.0);
    let tilted = read_dxf(&dxf("0;CIRCLE;10;0;20;0;40;2;210;0;220;0.6;230;0.8;")).unwrap_err();
    assert_eq!(
        tilted.to_string(),
        "DXF file, line 6: CIRCLE with the extrusion direction 0, 0.6, 0.8 is not supported, expected 0, 0, 1 or 0, 0, -1: \
         draw it in the plane x, y"
    );
}

#[test]
fn entities_of_dxf_that_are_not_shown_are_counted() {
    let layers = "0\nSECTION\n2\nTABLES\n0\nTABLE\n2\nLAYER\n\
        0\nLAYER\n2\nOff\n70\n0\n62\n-7\n0\nLAYER\n2\ncold\n70\n1\n62\n7\n0\nLAYER\n2\nshown\n70\n4\n62\n7\n\
        0\nENDTAB\n0\nENDSEC\n";
    let circle = |fields: &str| format!("0;CIRCLE;{fields}10;0;20;0;40;2;");
    let entities = [
        circle("8;shown;60;0;"),
        circle("8;shown;60;1;"),
        circle("8;OFF;"),
        circle("8;cold;"),
        "0;SPLINE;8;cold;0;TEXT;8;cold;1;a;".to_owned(),
        "0;POLYLINE;8;off;0;VERTEX;8;shown;10;1;20;0;0;VERTEX;8;shown;10;2;20;0;0;SEQEND;"
            .to_owned(),
    ];
    let file = [layers.as_bytes(), &dxf(&entities.concat())].concat();
    let (lines, left_out) = read_dxf_and_count(&file).unwrap();
    assert_eq!(lines, read_dxf(&dxf(&circle(""))).unwrap());
    let counted = |name: &str| left_out.get(name).copied();
    assert_eq!(counted("CIRCLE not shown"), Some(3));
    assert_eq!([counted("SPLINE not shown"), counted("POLYLINE not shown")], [Some(1); 2]);
    assert_eq!(left_out.len(), 3);
}
