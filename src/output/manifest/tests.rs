use super::super::write_atomically;
use super::*;

fn write(folder: &Path, name: &str, text: &str) {
    write_atomically(folder.join(name), |file| file.write_all(text.as_bytes())).unwrap();
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap().flatten();
    let mut names: Vec<String> = entries
        .map(|entry| entry.file_name().into_string().unwrap())
        .filter(|name| !name.starts_with(LIST))
        .collect();
    names.sort();
    names
}

#[test]
fn only_what_is_listed_and_unchanged_is_removed() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    let list = Manifest::start(place).unwrap();
    for name in ["a.csv", "b.csv", "same-size.csv", "copied.csv"] {
        write(place, name, "result");
    }
    drop(list);
    fs::write(place.join("history-mine.csv"), "mine").unwrap();
    fs::write(place.join("b.csv"), "result, annotated").unwrap();
    fs::write(place.join("same-size.csv"), "Result").unwrap();
    // A copy has another time and the same content.
    fs::write(place.join("copied.csv"), "result").unwrap();
    remove_results(place).unwrap();
    assert_eq!(names(place), ["b.csv", "history-mine.csv", "same-size.csv"]);
}

#[test]
fn what_stands_in_the_way_of_a_result_is_kept_under_another_name() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    fs::write(place.join("a.csv"), "mine").unwrap();
    fs::write(place.join("a.csv.kept"), "mine of before").unwrap();
    let list = Manifest::start(place).unwrap();
    write(place, "a.csv", "first");
    write(place, "a.csv", "second");
    let read = |name: &str| fs::read_to_string(place.join(name)).unwrap();
    assert_eq!(read("a.csv"), "second");
    assert_eq!(read("a.csv.kept"), "mine of before");
    assert_eq!(read("a.csv.kept-2"), "mine");
    let kept: Vec<_> = list.kept().iter().map(|path| name(path)).collect();
    assert_eq!(kept, ["a.csv.kept-2"]);
    assert_eq!(names(place).len(), 3);
}

#[test]
fn a_file_that_grows_is_known_by_its_last_content() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    let path = place.join("h.csv");
    let append = |text: &str| {
        let mut file = OpenOptions::new().append(true).open(&path).unwrap();
        file.write_all(text.as_bytes()).unwrap();
    };
    let list = Manifest::start(place).unwrap();
    write(place, "h.csv", "time\n");
    grows(&path).unwrap();
    append("1\n");
    drop(list);
    let before = fs::read(place.join(LIST)).unwrap();
    append("a remark\n");
    remove_results(place).unwrap();
    assert_eq!(names(place), ["h.csv"], "it was changed after the run");
    // A run that was killed did not come to say how it ended.
    let lines = String::from_utf8(before).unwrap();
    let killed: Vec<&str> = lines
        .lines()
        .filter(|line| !line.starts_with("sum"))
        .collect();
    fs::write(place.join(LIST), killed.join("\n") + "\n").unwrap();
    remove_results(place).unwrap();
    assert!(names(place).is_empty());
}

#[test]
fn temporary_files_of_a_killed_run_go_and_those_of_others_stay() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    let list = Manifest::start(place).unwrap();
    // What a writer sees of its own temporary file is what a kill would leave.
    let mut left = None;
    write_atomically(place.join("a.vtu"), |_| {
        left = names(place).pop();
        Ok(())
    })
    .unwrap();
    drop(list);
    let left = left.unwrap();
    assert!(
        left.starts_with(".perifrac-") && left.ends_with(".part"),
        "{left}"
    );
    for name in [&left, ".perifrac-mine.part", "thesis.part"] {
        fs::write(place.join(name), "half").unwrap();
    }
    remove_results(place).unwrap();
    assert_eq!(names(place), [".perifrac-mine.part", "thesis.part"]);
}

#[test]
fn a_list_that_was_tampered_with_leads_nowhere_else() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("out");
    fs::create_dir_all(place.join("sub")).unwrap();
    let outside = folder.path().join("thesis.tex");
    for path in [
        &outside,
        &place.join("sub/a"),
        &place.join("plain.part"),
        &place.join("torn"),
    ] {
        fs::write(path, "mine").unwrap();
    }
    let lines = format!(
        "file ../thesis.tex\npart ../thesis.tex\nfile {}\nfile sub/a\nfile sub\nfile ..\n\
         part plain.part\nsum zz 1 2 torn\nsum \n\nfile torn",
        outside.display()
    );
    fs::write(place.join(LIST), lines).unwrap();
    std::os::unix::fs::symlink(&outside, place.join("link")).unwrap();
    fs::write(place.join(format!("{LIST}-notes")), "file plain.part\n").unwrap();
    remove_results(&place).unwrap();
    assert!(outside.exists());
    assert_eq!(names(&place), ["link", "plain.part", "sub", "torn"]);
}

#[test]
fn further_processes_have_lists_of_their_own() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    let mine = Manifest::follow(place).unwrap();
    write(place, "piece-1.vtu", "piece");
    drop(mine);
    let own = format!("{LIST}-{}", std::process::id());
    assert!(place.join(&own).exists());
    remove_results(place).unwrap();
    assert!(names(place).is_empty() && !place.join(own).exists());
    let list = Manifest::start(place).unwrap();
    let other = Manifest::follow(place).unwrap();
    assert!(Arc::ptr_eq(&list.0, &other.0), "one list in one process");
}

#[test]
fn a_page_that_is_added_later_is_replaced_with_the_results() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    assert!(Manifest::resume(place).unwrap().is_none());
    drop(Manifest::start(place).unwrap());
    for text in ["first", "second"] {
        let _list = Manifest::resume(place).unwrap().unwrap();
        write(place, "report.html", text);
    }
    assert_eq!(names(place), ["report.html"]);
    remove_results(place).unwrap();
    assert!(names(place).is_empty());
}
