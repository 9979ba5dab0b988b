use std::fmt::Write as _;
use std::path::Path;

use crate::csv_columns::{COLUMNS, POSE_COLUMNS};
use crate::csv_header::CsvHeader;
use crate::homogeneous::{pose_of_rows, rows_of_pose};
use crate::{Grasp, GraspError, GraspSet, RobustScore};

/// Reads the grasps of a `grasps.csv`: a line for each, the 16 numbers of `planning_from_gripper` row by row (metres),
/// then score and width (m), then robust score and the number of its trials, then the load. All fields after the pose may
/// be empty or absent, as in the files of the paper's release. A first line without any number is a header, which names
/// the columns and their order.
///
/// # Errors
/// [`GraspError::Line`] with file and line for an invalid grasp or header, [`GraspError::Empty`] for a file without
/// grasps, [`GraspError::Unreadable`].
pub fn read_csv(path: &Path) -> Result<GraspSet, GraspError> {
    let text = cranny_file::TABLE
        .text(path)
        .map_err(|reason| GraspError::Unreadable { path: path.to_owned(), reason })?;
    parse_csv(path, &text)
}

/// Parses a text in the format of [`read_csv`]; errors name `path`.
///
/// # Errors
/// As [`read_csv`].
pub fn parse_csv(path: &Path, text: &str) -> Result<GraspSet, GraspError> {
    let (grasps, faults) = check_csv(path, text);
    match faults.into_iter().next() {
        Some(fault) => Err(fault),
        None => Ok(grasps),
    }
}

/// Parses the valid lines of a text to grasps, and returns the faults of the others.
pub fn check_csv(path: &Path, text: &str) -> (GraspSet, Vec<GraspError>) {
    let at_line = |index: usize, fault: GraspError| GraspError::Line {
        path: path.to_owned(),
        line: index + 1,
        fault: Box::new(fault),
    };
    let named = match CsvHeader::of(text.lines().next().unwrap_or_default()) {
        Ok(named) => named,
        // The meaning of the columns is unknown.
        Err(fault) => return (GraspSet::default(), vec![at_line(0, fault)]),
    };
    let (header, from) = named.map_or((CsvHeader::absent(), 0), |named| (named, 1));
    let mut sound = Vec::new();
    let mut faults = Vec::new();
    for (index, line) in text.lines().enumerate().skip(from) {
        if line.trim().is_empty() {
            continue;
        }
        // Faults of a single grasp refer to it by its position in the file.
        let place = sound.len() + faults.len();
        let checked = parse(&header, line, place).and_then(|grasp| grasp.checked(place));
        match checked {
            Ok(grasp) => sound.push(grasp),
            Err(fault) => faults.push(at_line(index, fault)),
        }
    }
    if sound.is_empty() && faults.is_empty() {
        faults.push(GraspError::Empty { path: path.to_owned() });
    }
    (GraspSet::of_checked(sound), faults)
}

/// Returns a text in the format of [`read_csv`], with a header. Unknown values stay empty; there are no columns for robust scores
/// or loads if no grasp has one.
pub fn csv_text(grasps: &GraspSet) -> String {
    let mut text = String::new();
    let is_robust = grasps.grasps().iter().any(|grasp| grasp.robust.is_some());
    let is_loaded = grasps.grasps().iter().any(|grasp| grasp.load.is_some());
    let [known, robust, loaded] = [&COLUMNS[..18], &COLUMNS[18..20], &COLUMNS[20..]];
    let optional = [(is_robust, robust), (is_loaded, loaded)].into_iter().filter(|(is_there, _)| *is_there);
    let named: Vec<&str> = known.iter().chain(optional.flat_map(|(_, names)| names)).copied().collect();
    text.push_str(&named.join(","));
    text.push('\n');
    for grasp in grasps.grasps() {
        for number in rows_of_pose(&grasp.world_from_gripper) {
            let _ = write!(text, "{number},");
        }
        let or_empty = |value: Option<f64>| value.map_or_else(String::new, |x| x.to_string());
        let _ = write!(text, "{},{}", or_empty(grasp.score), or_empty(grasp.width_m));
        match grasp.robust {
            Some(robust) => {
                let _ = write!(text, ",{},{}", robust.score(), robust.trials);
            }
            None if is_robust => text.push_str(",,"),
            None => {}
        }
        if is_loaded {
            let _ = write!(text, ",{}", or_empty(grasp.load));
        }
        text.push('\n');
    }
    text
}

fn parse(header: &CsvHeader, line: &str, place: usize) -> Result<Grasp, GraspError> {
    // Fields are counted before they are kept, because a line may have any number of them.
    let actual = line.split(',').count();
    header.check_count(actual)?;
    let fields: Vec<&str> = line.split(',').map(str::trim).collect();
    let number = |index: usize| -> Result<f64, GraspError> {
        let not_a_number =
            || GraspError::NotANumber { column: index + 1, text: cranny_file::excerpt(fields[index]) };
        fields[index].parse().ok().filter(|x: &f64| x.is_finite()).ok_or_else(not_a_number)
    };
    let optional = |column: usize| -> Result<Option<f64>, GraspError> {
        match header.place(column).filter(|index| fields.get(*index).is_some_and(|field| !field.is_empty())) {
            None => Ok(None),
            Some(index) => number(index).map(Some),
        }
    };
    let mut rows = [0.0; 16];
    for (column, entry) in rows.iter_mut().enumerate() {
        *entry = number(header.place(column).ok_or(GraspError::NumberCount { actual })?)?;
    }
    let world_from_gripper = pose_of_rows(&rows)?;
    let [score, width_m, robust_score, robust_trials, load] =
        [0, 1, 2, 3, 4].map(|further| optional(POSE_COLUMNS + further));
    let (score, width_m, load) = (score?, width_m?, load?);
    let robust = match (robust_score?, robust_trials?) {
        (None, None) => None,
        (Some(score), Some(trials)) => {
            Some(RobustScore::of_share(score, trials).ok_or(GraspError::Robust {
                grasp: place,
                score,
                trials,
            })?)
        }
        _ => return Err(GraspError::HalfRobust),
    };
    Ok(Grasp { world_from_gripper, score, width_m, robust, load, has_no_twin: false })
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use cranny_spatial::{Pose, PoseDifference, Stream, Vector};

    const IDENTITY: &str = "1,0,0,0.1,0,1,0,0.2,0,0,1,0.3,0,0,0,1";

    fn read(text: &str) -> Result<GraspSet, GraspError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("grasps.csv");
        fs::write(&path, text).unwrap();
        read_csv(&path)
    }

    fn fault(text: &str) -> String {
        read(text).unwrap_err().to_string()
    }

    #[test]
    fn what_is_written_is_read_back() {
        let mut random = Stream::new(11, 0);
        let grasps: Vec<Grasp> = (0..50)
            .map(|index| Grasp {
                world_from_gripper: Pose::from_parts(
                    Vector::new(random.normal(), random.normal(), random.normal()).into(),
                    random.rotation(),
                ),
                score: (index % 3 > 0).then(|| random.uniform()),
                width_m: (index % 2 > 0).then_some(0.0647),
                robust: (index % 5 > 0).then_some(RobustScore { trials: 32, held: index % 33 }),
                load: (index % 7 > 0).then(|| 9.0 * random.uniform()),
                has_no_twin: false,
            })
            .collect();
        let written = GraspSet::new(grasps).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("grasps.csv");
        fs::write(&path, csv_text(&written)).unwrap();
        let read = read_csv(&path).unwrap();
        assert_eq!(read.len(), 50);
        for (a, b) in written.grasps().iter().zip(read.grasps()) {
            assert_eq!((a.score, a.width_m, a.robust, a.load), (b.score, b.width_m, b.robust, b.load));
            let difference = PoseDifference::between(&a.world_from_gripper, &b.world_from_gripper);
            assert!(difference.translation_m == 0.0 && difference.rotation_rad < 1e-14);
        }
    }

    #[test]
    fn score_and_width_may_be_empty_or_absent() {
        let set = read(&format!("{IDENTITY}\n{IDENTITY},,\n\n{IDENTITY},0.5\n{IDENTITY},,0.02\r\n")).unwrap();
        let found: Vec<_> = set.grasps().iter().map(|g| (g.score, g.width_m)).collect();
        assert_eq!(found, [(None, None), (None, None), (Some(0.5), None), (None, Some(0.02))]);
        assert_eq!(set.grasps()[0].world_from_gripper, Pose::translation(0.1, 0.2, 0.3));
    }

    #[test]
    fn a_file_has_columns_for_robust_scores_only_where_there_are_any() {
        let without = read(&format!("{IDENTITY},0.5,0.02\n{IDENTITY}\n")).unwrap();
        let lines = |set: &GraspSet| csv_text(set).lines().map(str::to_owned).collect::<Vec<_>>();
        assert!(lines(&without)[0].ends_with(",t33,score,width_m"));
        assert!(
            lines(&without)[1..].iter().zip([",1,0.5,0.02", ",1,,"]).all(|(line, end)| line.ends_with(end))
        );
        let with = read(&format!("{IDENTITY},0.5,0.02,0.97,32\n{IDENTITY},,,,\n")).unwrap();
        assert_eq!(with.grasps()[0].robust, Some(RobustScore { trials: 32, held: 31 }));
        assert!(lines(&with)[0].ends_with(",score,width_m,robust_score,robust_trials"));
        let ends = [",1,0.5,0.02,0.96875,32", ",1,,,,"];
        assert!(lines(&with)[1..].iter().zip(ends).all(|(line, end)| line.ends_with(end)));
    }

    #[test]
    fn a_file_has_a_column_for_loads_only_where_there_are_any() {
        let pose = COLUMNS[..16].join(",");
        let read = read(&format!("{pose},load\n{IDENTITY},2.5\n{IDENTITY}\n")).unwrap();
        assert_eq!(read.grasps().iter().map(|grasp| grasp.load).collect::<Vec<_>>(), [Some(2.5), None]);
        let text = csv_text(&read);
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[0].ends_with(",t33,score,width_m,load"), "{}", lines[0]);
        assert!(lines[1].ends_with(",1,,,2.5") && lines[2].ends_with(",1,,,"), "{text}");
    }

    #[test]
    fn faults_name_file_and_line() {
        let after_one = |line: &str| fault(&format!("{IDENTITY}\n{line}\n"));
        let fifteen = after_one(&IDENTITY[2..]);
        assert!(fifteen.contains("grasps.csv:2: 15 numbers instead of 16"), "{fifteen}");
        let nan = after_one(&IDENTITY.replace("0.2", "NaN"));
        assert!(nan.contains("grasps.csv:2: number 8 is 'NaN'"), "{nan}");
        let word = after_one(&IDENTITY.replace("0.3", "x"));
        assert!(word.contains("grasps.csv:2: number 12 is 'x'"), "{word}");
        assert!(after_one(&IDENTITY.replace("0.1", "1e999")).contains("not a finite number"));
        assert!(after_one(&format!("{}2", &IDENTITY[..IDENTITY.len() - 1])).contains("last row"));
        assert!(after_one(&IDENTITY.replace("0,0,1,0.3", "0,0,-1,0.3")).contains("left-handed"));
        assert!(after_one(&IDENTITY.replace("0,0,1,0.3", "0,0,2,0.3")).contains("no rotation"));
        assert!(after_one(&format!("{IDENTITY},1.5")).contains("grasps.csv:2: the score of grasp 1 is 1.5"));
        assert!(after_one(&format!("{IDENTITY},,-1")).contains("grasps.csv:2: the width of grasp 1"));
        assert!(after_one(&format!("{IDENTITY},nan")).contains("number 17"));
        let robust = after_one(&format!("{IDENTITY},,,1.5,32"));
        assert!(robust.contains("grasps.csv:2: the robust score of grasp 1 is 1.5 of 32 trials"), "{robust}");
        assert!(after_one(&format!("{IDENTITY},,,0.5,0")).contains("is 0.5 of 0 trials"));
        assert!(after_one(&format!("{IDENTITY},,,0.5,3")).contains("the share that held"));
        assert!(after_one(&format!("{IDENTITY},,,NaN,32")).contains("number 19 is 'NaN'"));
        assert!(after_one(&format!("{IDENTITY},,,0.5")).contains("there is only one; give both"));
        assert!(after_one(&format!("{IDENTITY},,,,32")).contains("there is only one; give both"));
        assert!(after_one(&format!("{IDENTITY},,,,,-1")).contains("the load of grasp 1"));
        assert!(after_one(&format!("{IDENTITY},0,0,0,1,0,0")).contains("22 numbers instead of 16"));
    }

    #[test]
    fn a_file_without_grasps_is_a_fault() {
        assert!(matches!(read(""), Err(GraspError::Empty { .. })));
        assert!(matches!(read(&format!("{}\n", COLUMNS.join(","))), Err(GraspError::Empty { .. })));
        assert!(matches!(read_csv(Path::new("no/such/grasps.csv")), Err(GraspError::Unreadable { .. })));
    }

    /// Guards against reading by position under a header that exchanges `score` and `width_m`.
    #[test]
    fn a_header_names_the_columns_in_any_order() {
        let pose = COLUMNS[..16].join(",");
        let grasp = |text: &str| read(text).unwrap().grasps()[0];
        let turned = grasp(&format!("{pose},width_m,score\n{IDENTITY},0.06,0.9\n"));
        assert_eq!((turned.score, turned.width_m), (Some(0.9), Some(0.06)));
        let alone = grasp(&format!("# {pose}, width_m\r\n{IDENTITY},0.06\r\n"));
        assert_eq!((alone.score, alone.width_m), (None, Some(0.06)));
        let before = grasp(&format!("\u{feff}robust_trials,robust_score,{pose}\n32,0.5,{IDENTITY}\n"));
        assert_eq!(before.robust, Some(RobustScore { trials: 32, held: 16 }));
        assert_eq!(before.world_from_gripper, Pose::translation(0.1, 0.2, 0.3));
        let short = grasp(&format!("{pose},score,width_m\n{IDENTITY}\n"));
        assert_eq!((short.score, short.width_m), (None, None));
    }

    #[test]
    fn a_header_that_is_not_understood_is_refused_by_name() {
        let pose = COLUMNS[..16].join(",");
        let centimetres = fault(&format!("{pose},score,width_cm\n{IDENTITY},0.9,6\n"));
        for words in [
            "grasps.csv:1: column 18",
            "'width_cm'",
            "did you mean 'width_m'?",
            "t00 to t33",
            "robust_trials",
        ] {
            assert!(centimetres.contains(words), "no {words} in: {centimetres}");
        }
        let twice = fault(&format!("{pose},score,score\n{IDENTITY},0.9,0.9\n"));
        assert!(twice.contains("grasps.csv:1: columns 17 and 18 of the header are both 'score'"), "{twice}");
        let without = fault(&format!("{}\n{IDENTITY}\n", COLUMNS[1..16].join(",")));
        assert!(without.contains("grasps.csv:1: the header has no column 't00'"), "{without}");
        let unnamed = fault(&format!("{pose},\n{IDENTITY},0.9\n"));
        assert!(unnamed.contains("column 17 of the header is ''"), "{unnamed}");
        let more = fault(&format!("{pose},score\n{IDENTITY},0.9,0.06\n"));
        assert!(more.contains("grasps.csv:2: 18 numbers under a header of 17 columns"), "{more}");
        // Every fault of the lines would be a guess.
        let (set, faults) = check_csv(Path::new("grasps.csv"), &format!("{pose},grade\n{IDENTITY},7\n"));
        assert_eq!((set.len(), faults.len()), (0, 1));
    }

    #[test]
    fn a_first_line_with_a_slip_is_no_header() {
        assert!(fault(&IDENTITY.replace("0.1", "o.1")).contains("grasps.csv:1"));
    }
}
