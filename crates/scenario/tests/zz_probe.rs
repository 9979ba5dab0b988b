use cranny_collision::Margins;
use cranny_scenario::{OpenOptions, Scenario};
#[test]
fn zz_probe() {
    let mut names: Vec<String> = Vec::new();
    for f in 1..=4 {
        for l in 1..=5 {
            names.push(format!("0{f}{l}"));
            names.push(format!("1{f}{l}"));
        }
    }
    for n in ["213", "235", "245"] {
        names.push(n.into());
    }
    let root = "/work/shared/data/jogramop/scenarios";
    let mut rel: Vec<String> =
        std::fs::read_dir(root).unwrap().map(|e| e.unwrap().path().to_str().unwrap().to_owned()).collect();
    rel.sort();
    names.extend(rel);
    for n in names {
        let Ok(s) = Scenario::open(&n, &OpenOptions::default()) else {
            println!("{n}: not opened");
            continue;
        };
        let p = s.problem(Margins::default()).unwrap();
        let Some(cell) = p.cell() else { continue };
        let Some(t) = p.target() else { continue };
        let at = std::time::Instant::now();
        match cell.resting(t) {
            Ok(r) => {
                let bodies: Vec<String> = r
                    .supports()
                    .map(|(b, s)| format!("{} {:.4}mm", cell.world().bodies()[b].name, s * 1e3))
                    .collect();
                println!(
                    "{n}: {:?} off {:?} beside {:?} {:?} in {:?}",
                    bodies,
                    r.overhang_m(),
                    r.beside().collect::<Vec<_>>(),
                    cell.world().up(),
                    at.elapsed()
                );
            }
            Err(e) => println!("{n}: {e}"),
        }
    }
}
