// SPDX-License-Identifier: MIT OR Apache-2.0
//! Files in one call, as an asset pipeline makes them.

use std::path::Path;

use brdf_baker::Error;
use brdf_baker::asset::Baker;
use brdf_baker::bake::TableRequest;
use brdf_baker::bake::specular::SpecularRequest;
use brdf_baker::format::{self, Encoding};
use brdf_baker::texture::Shape;
use brdf_baker::verify::certificate::{Certificate, Verdict};

const SKY: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/fuzz/corpus/environment/runs.hdr");

fn baker() -> Baker {
    Baker::open("cpu").expect("there is a processor")
}

/// Files in a folder.
fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    entries.map(|entry| entry.expect("readable").file_name().to_string_lossy().into_owned()).collect()
}

#[test]
fn a_table_and_an_environment_are_baked_and_certified() {
    let folder = tempfile::tempdir().expect("a folder");
    let (table, cube) = (folder.path().join("dfg.ktx2"), folder.path().join("sky.exr"));
    let baker = baker();
    let request = TableRequest { size: (16, 16), ..TableRequest::new("split-sum") };
    let written = baker.table(&request, &table).expect("a table");
    assert_eq!(written.bytes, table.metadata().expect("a file").len());
    let request = SpecularRequest { size: Some(8), ..SpecularRequest::default() };
    baker.environment(SKY, &request, &cube).expect("an environment");

    for (path, shape, levels, keys) in [
        (&table, Shape::Table, 1, ["error.worst", "error.median", "error.bound", "error.checked"]),
        (&cube, Shape::Cube, 4, ["error.relative.rms", "error.relative.worst", "error.bound", "error.checked"]),
    ] {
        let (texture, encoding) = format::for_path(path).unwrap().read(path).expect("readable");
        assert_eq!((texture.shape, texture.levels.len(), encoding.repr), (shape, levels, format::Repr::F16));
        assert!(keys.iter().all(|key| texture.meta.get(key).is_some()), "{:?}", texture.meta);
        let certificate = Certificate::texels(&texture, encoding).expect("a certificate");
        let confirmed = certificate.claims.iter().filter(|claim| claim.verdict == Verdict::Confirmed);
        assert_eq!(confirmed.map(|claim| claim.key).collect::<Vec<_>>(), ["texels.sha256"]);
    }
    let (texture, _) = format::for_path(&cube).unwrap().read(&cube).expect("readable");
    assert_eq!(texture.meta.get("input"), Some("runs.hdr"));
}

#[test]
fn what_cannot_be_done_is_refused_before_a_file_is_there() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let baker = baker();
    let small = SpecularRequest { size: Some(8), ..SpecularRequest::default() };
    let unknown = TableRequest::new("split-sun");
    let tall = TableRequest { size: (8, 0), ..TableRequest::new("split-sum") };
    let narrow = Baker { encoding: Encoding::parse("r8unorm").ok(), ..Baker::open("cpu").unwrap() };
    let is_usage = |error: Error| matches!(error, Error::Usage { .. });
    assert!(is_usage(baker.table(&unknown, at("a.ktx2")).unwrap_err()));
    assert!(is_usage(baker.table(&tall, at("a.ktx2")).unwrap_err()));
    assert!(is_usage(narrow.table(&TableRequest::new("split-sum"), at("a.ktx2")).unwrap_err()));
    assert!(is_usage(baker.environment(SKY, &small, at("a.hdr")).unwrap_err()), "a cube in a picture");
    assert!(is_usage(
        baker.environment(SKY, &SpecularRequest { size: Some(9), ..small.clone() }, at("a.env")).unwrap_err()
    ));
    let missing = baker.environment(at("missing.exr"), &small, at("a.ktx2")).unwrap_err();
    assert!(matches!(missing, Error::Io { .. }), "{missing}");
    let nowhere = baker.table(&TableRequest { size: (4, 4), ..TableRequest::new("split-sum") }, at("no/a.ktx2"));
    assert!(matches!(nowhere.unwrap_err(), Error::Io { .. }));
    assert_eq!(names(folder.path()), [""; 0]);
}
