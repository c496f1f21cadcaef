use super::*;

#[test]
fn grids_are_ordered_and_counted_whatever_the_order_of_names() {
    let name = |v: usize, l: usize| format!("X/tv{v:03}_pv000/00000 tl{l:03} pl090 tv{v:03} pv000.jpg");
    let mut names: Vec<String> = (0..3).flat_map(|v| (0..4).map(move |l| name(15 * v, 15 * l))).collect();
    let sorted = PairList::of_paths(names.iter().map(String::as_str)).unwrap().unwrap();
    assert_eq!((sorted.lights, sorted.views, sorted.missing_count), (4, 3, 0));
    names.reverse();
    names.push("readme.txt".to_owned());
    let again = PairList::of_paths(names.iter().map(String::as_str)).unwrap().unwrap();
    let of = |list: &PairList| list.entries.iter().map(|e| e.name.clone()).collect::<Vec<_>>();
    assert_eq!(of(&sorted), of(&again));
    assert_eq!(again.entries[0].index, Some(11));
    assert!(PairList::of_paths(["a.jpg", "notes"]).unwrap().is_none());
}

#[test]
fn pictures_without_angles_are_counted_and_named() {
    let names =
        ["tl1 pl2 tv3 pv4.png", "b/extra.jpg", "notes.txt", "truth/albedo.exr", "tl0-15 pl0 tv0 pv0.png"];
    let list = PairList::of_paths(names).unwrap().unwrap();
    assert_eq!(list.unnamed, ["extra.jpg", "tl0-15 pl0 tv0 pv0.png"]);
    let sentence = list.left_out().unwrap();
    assert!(sentence.starts_with("2 pictures") && sentence.contains("extra.jpg"), "{sentence}");
}

#[test]
fn a_folder_is_a_set_where_some_photograph_below_has_angles_and_no_light_file_is_beside() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str| {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, "").unwrap();
    };
    write("a/b/notes.txt");
    write("a/.tl1 pl2 tv3 pv4.png");
    assert!(!is_set(folder.path()));
    write("a/b/tl1 pl2 tv3 pv4.png");
    assert!(is_set(folder.path()));
    write("lights.lp");
    assert!(!is_set(folder.path()) && is_set(&folder.path().join("a")));
    assert!(!is_set(&folder.path().join("absent")));
}

#[test]
fn missing_photographs_are_counted_and_doubles_refused() {
    let name = |v: usize, l: usize| format!("tl{l} pl0 tv{v} pv0.png");
    let names: Vec<String> = (0..5).flat_map(|v| (0..5).map(move |l| name(v, l))).skip(2).collect();
    let list = PairList::of_paths(names.iter().map(String::as_str)).unwrap().unwrap();
    assert_eq!(list.missing_count, 2);
    let error = list.check_complete().unwrap_err().to_string();
    assert!(error.contains("2 of the 25") && error.contains("tl0 pl0 tv0 pv0"), "{error}");
    assert!(error.contains("--missing fill"), "{error}");
    let pairs = |list: &PairList| list.entries.iter().map(|e| e.directions).collect::<Vec<_>>();
    let whole: Vec<String> = (0..5).flat_map(|v| (0..5).map(move |l| name(v, l))).collect();
    let whole = PairList::of_paths(whole.iter().map(String::as_str)).unwrap().unwrap();
    let filled = list.filled();
    assert!(pairs(&filled) == pairs(&whole) && filled.missing_count == 0);
    assert_eq!(filled.entries.iter().filter(|entry| entry.index.is_none()).count(), 2);
    // A name that was not understood may be all that is wrong.
    let names = (0..4).map(|i| name(i / 2, i % 2)).take(3).chain(["tl-1 pl0 tv1 pv0.png".to_owned()]);
    let names: Vec<String> = names.collect();
    let list = PairList::of_paths(names.iter().map(String::as_str)).unwrap().unwrap();
    let error = list.check_complete().unwrap_err().to_string();
    assert!(error.contains("1 of the 4") && error.contains("tl-1 pl0 tv1 pv0.png"), "{error}");
    let twice =
        PairList::of_paths(["a tl1 pl2 tv3 pv4.png", "tv3_pv4_tl1_pl2.0.jpg"]).unwrap_err().to_string();
    assert!(twice.contains("same directions"), "{twice}");
    // Two single pairs, neither.
    let two = ["tl1 pl2 tv3 pv4.png", "tl5 pl6 tv7 pv8.png"];
    let two = PairList::of_paths(two).unwrap().unwrap();
    assert_eq!(two.missing_count, 0);
    let sentence = two.check_grid("a model").unwrap_err().to_string();
    assert!(
        sentence.contains("2 pairs of 2 lights and 2 views") && sentence.contains("a model"),
        "{sentence}"
    );
    // Irregular pairs are no grid with holes.
    let irregular: Vec<String> = (0..9).map(|i| name(i, 8 - i)).collect();
    assert_eq!(PairList::of_paths(irregular.iter().map(String::as_str)).unwrap().unwrap().missing_count, 0);
}
