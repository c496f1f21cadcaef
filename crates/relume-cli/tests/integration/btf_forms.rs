//! Textures of light and view that are not linear in the numbers of their texels: every verb takes them as they are, keeps them, or
//! says what it cannot do.

use std::path::Path;

use serde_json::Value;

use crate::btf::{photographs, write_zip};
use crate::support::{done, failed, json, names, refused, run};

/// A set of photographs, and a texture of each form of it.
fn forms(path: &Path, models: &[&str]) {
    write_zip(&path.join("b.zip"), &photographs());
    for model in models {
        done(path, &["fit", "b.zip", "-o", &format!("{model}.exr"), "--model", model]);
    }
    done(path, &["fit", "b.zip", "-o", "c.exr", "--rank", "6", "--clusters", "3", "--cluster-axes", "2"]);
}

#[test]
fn converting_keeps_models_and_clusters_where_the_format_holds_them() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    forms(path, &["ggx", "views-ptm"]);
    for (name, model) in [("ggx", "ggx"), ("views-ptm", "views-ptm")] {
        let kept = json(path, &["convert", &format!("{name}.exr"), "-o", "k.exr", "--force"]);
        assert_eq!((&kept["form"]["model"], &kept["loss"]), (&model.into(), &Value::Null), "{kept}");
        let [a, b] = [format!("{name}.exr"), "k.exr".to_owned()].map(|f| json(path, &["info", &f]));
        assert_eq!((&a["planes"], &a["model"]), (&b["planes"], &model.into()));
        assert!(kept["warnings"].as_array().unwrap().is_empty(), "{kept}");
    }
    let kept = json(path, &["convert", "c.exr", "-o", "k.exr", "--force"]);
    assert_eq!((&kept["form"]["clusters"], &kept["form"]["cluster_axes"]), (&3.into(), &2.into()), "{kept}");
    let half = json(path, &["convert", "c.exr", "-o", "h.exr", "--half"]);
    assert!(half["loss"]["largest"].as_f64().unwrap() > 0.0, "{half}");
    assert_eq!(json(path, &["info", "h.exr"])["clusters"]["count"], 3);
    let plain = run(path, &["convert", "c.exr", "-o", "c.npz"]);
    assert!(plain.contains("3 clusters of 2 axes") && plain.contains("without the clusters"), "{plain}");
}

#[test]
fn functions_made_of_models_are_measured_against_the_models() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    forms(path, &["ggx", "views-ptm"]);
    let exact = json(path, &["convert", "views-ptm.exr", "-o", "v.ptm"]);
    assert!(exact["loss"]["rms"].as_f64().unwrap() < 0.01, "{exact}");
    let lossy = json(path, &["convert", "ggx.exr", "-o", "g.npz"]);
    assert_eq!(lossy["from"]["model"], "ggx");
    assert!(lossy["loss"]["rms"].as_f64().unwrap() > 0.0, "{lossy}");
    let refused = refused(path, &["convert", "ggx.exr", "-o", "g2.exr", "--space", "srgb"]);
    assert!(refused.contains("--basis hsh9"), "{refused}");
}

#[test]
fn models_are_compared_as_they_are_and_the_views_are_said() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    forms(path, &["ggx", "views-ptm"]);
    let same = json(path, &["compare", "ggx.exr", "ggx.exr"]);
    assert_eq!((&same["psnr_db"], &same["rmse"]), (&Value::Null, &0.0.into()));
    assert!(same["warnings"].as_array().unwrap().is_empty(), "{same}");
    let text = run(path, &["compare", "ggx.exr", "ggx.exr"]);
    assert!(text.contains("equal") && !text.contains("inf"), "{text}");
    assert!(text.contains("5 lights, 2 of them seen from the side"), "{text}");
    // Functions of the light for each view are photographs to a hair; their linear form is not.
    let compared = json(path, &["compare", "b.zip", "views-ptm.exr"]);
    let said = json(path, &["fit", "b.zip", "-o", "again.exr", "--model", "views-ptm"]);
    let [compared, said] =
        [&compared["rmse"], &said["report"]["fitted"]["rmse"]].map(|rmse| rmse.as_f64().unwrap());
    assert!(compared < 1.5 * said && said < 0.003, "{compared} where the fit said {said}");
    let order = refused(path, &["compare", "ggx.exr", "b.zip"]);
    assert!(order.contains("relume compare b.zip ggx.exr"), "{order}");
}

#[test]
fn normals_of_facets_are_those_fitted_and_lobes_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    forms(path, &["ggx", "lafortune1", "views-ptm"]);
    let info = json(path, &["info", "ggx.exr"]);
    let normals = json(path, &["relight", "ggx.exr", "--normals", "-o", "n.exr"]);
    assert!(normals["warnings"].as_array().unwrap().is_empty(), "{normals}");
    let of = |info: &Value, plane: &str, end: &str| {
        let all = info["planes"].as_array().unwrap();
        all.iter().find(|found| found["name"] == plane).unwrap()[end].as_f64().unwrap()
    };
    let found = json(path, &["info", "n.exr"]);
    for (plane, number) in [("R.1", "normal.x"), ("G.1", "normal.y")] {
        for end in ["min", "max"] {
            let (a, b) = (of(&found, plane, end), of(&info, number, end));
            assert!((a - b).abs() < 1e-3, "{plane} {end}: {a} and {b}");
        }
    }
    done(path, &["relight", "ggx.exr", "--albedo", "-o", "a.png"]);
    let height = run(path, &["height", "ggx.exr", "-o", "h.exr"]);
    assert!(height.contains("fitted facets"), "{height}");
    for verb in [
        &["relight", "lafortune1.exr", "--normals", "-o", "l.png"][..],
        &["height", "lafortune1.exr", "-o", "l.exr"],
        &["maps", "lafortune1.exr", "-o", "l", "--preset", "gltf"],
    ] {
        let sentence = refused(path, verb);
        assert!(sentence.contains("have no normals") && sentence.contains("--model ggx"), "{sentence}");
    }
    done(path, &["relight", "lafortune1.exr", "--albedo", "-o", "b.png"]);
    done(path, &["maps", "views-ptm.exr", "-o", "maps", "--preset", "blender"]);
    assert!(names(&path.join("maps")).iter().any(|name| name.contains("Normal")));
}

#[test]
fn info_says_the_form_the_grid_and_how_a_btf_is_stored() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    forms(path, &[]);
    let text = run(path, &["info", "c.exr"]);
    assert!(text.contains("texels in 3 clusters of 2 axes: 3 numbers a texel"), "{text}");
    assert!(text.contains("64 pairs of light and view, 8 lights x 8 views"), "{text}");
    let clusters = &json(path, &["info", "c.exr"])["clusters"];
    let texels: u64 = clusters["texels"].as_array().unwrap().iter().map(|n| n.as_u64().unwrap()).sum();
    assert_eq!((clusters["count"].as_u64(), texels), (Some(3), 576), "{clusters}");
    for (options, said, bits) in [
        (&[][..], "4 functions of all (FMF), 32-bit floats", 32),
        (
            &["--factors", "decorrelated", "--half"],
            "4, 1, 1 functions of the channels of a colour model (DFMF)",
            16,
        ),
        (&["--factors", "per-view"], "4 functions of each of 8 views (PVF)", 32),
    ] {
        done(path, &[&["fit", "b.zip", "-o", "b.btf", "--rank", "4", "--force"], options].concat());
        let text = run(path, &["info", "b.btf"]);
        assert!(text.contains(said), "{text}");
        assert_eq!(json(path, &["info", "b.btf"])["stored"]["bits"], bits);
    }
}

#[test]
fn info_says_what_files_for_other_programs_hold() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    forms(path, &[]);
    done(path, &["fit", "b.zip", "-o", "f.exr", "--rank", "3"]);
    done(path, &["maps", "f.exr", "-o", "m", "--preset", "gltf", "--textures", "bc7", "--preview", "plane"]);
    done(path, &["convert", "f.exr", "-o", "f.npz"]);
    done(path, &["share", "f.exr", "-o", "page"]);
    for (file, said) in [
        ("m/Material.glb", "mesh"),
        ("m/Material_baseColor.ktx2", "24 x 24 texels, 5 levels, sRGB colours in blocks of BC7"),
        ("f.npz", "coefficients: ("),
        ("page", "24 x 24 texels, basis learned"),
    ] {
        let text = run(path, &["info", file]);
        assert!(text.contains(said), "{file}: {text}");
        assert!(!json(path, &["info", file])["parts"].as_array().unwrap().is_empty());
    }
}

#[test]
fn a_description_of_a_folder_that_says_nothing_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    for (name, text) in [("info.xml", ""), ("info.xml", "<a/>"), ("info.json", ""), ("info.json", "[1]")] {
        let web = path.join("web");
        std::fs::create_dir(&web).unwrap();
        std::fs::write(web.join(name), text).unwrap();
        for input in ["web".to_owned(), format!("web/{name}")] {
            let sentence = failed(path, &["info", &input], 1);
            assert!(sentence.contains(name), "{input} of {text:?}: {sentence}");
            assert!(!sentence.contains("this is a folder"), "{sentence}");
        }
        std::fs::remove_dir_all(web).unwrap();
    }
}
