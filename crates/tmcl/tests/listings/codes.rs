//! What each listing deserves to be told, and no more.

use super::text::{as_suggested, assembled, codes, folder, instructions, listing, text};

/// Every listing and the codes that `tmcl check` has for it: the slips that the manuals print, and one STOP that follows an
/// endless loop.
const DESERVED: [(&str, &[&str]); 21] = [
    ("tmcm_1311_11_2", &[]),
    ("tmcm_1311_11_3", &[]),
    ("tmcm_1311_11_4", &["E0210"]),
    ("tmcm_1311_11_6", &[]),
    ("tmcm_1311_3_3_2", &[]),
    ("tmcm_1311_5_6_5", &[]),
    ("tmcm_1311_5_6_5_names", &[]),
    ("tmcm_1311_5_7_14", &[]),
    ("tmcm_1311_5_7_17", &["E0210", "W0015", "E0105"]),
    ("tmcm_1311_5_7_18", &["W0015"]),
    ("tmcm_1311_5_7_19", &[]),
    ("tmcm_1311_5_7_20", &[]),
    ("tmcm_1311_5_7_29", &[]),
    ("tmcm_1311_8_11_1", &["W0001"]),
    ("tmcm_1311_8_11_2", &[]),
    ("tmcm_1640_4_4", &[]),
    ("tmcm_1640_4_6_15", &["W0015", "E0105"]),
    ("tmcm_1640_4_6_16", &["W0015"]),
    ("tmcm_1640_4_6_17", &[]),
    ("tmcm_1640_4_6_18", &[]),
    ("tmcm_1640_4_6_22", &[]),
];

#[test]
fn every_listing_gets_what_it_deserves() {
    for (name, deserved) in DESERVED {
        let assembly = listing(name);
        assert_eq!(codes(&assembly), deserved, "{name}");
        assert!(assembly.module_is_named, "{name}");
        let module = assembly.program.module.id.replace('-', "_");
        assert!(name.starts_with(&module), "{name} was assembled for {module}");
    }
}

#[test]
fn no_listing_is_forgotten() {
    let files = std::fs::read_dir(folder()).expect("the listings' folder");
    let mut found: Vec<_> = files
        .map(|file| file.expect("an entry").path())
        .map(|path| path.file_stem().expect("a name").to_string_lossy().into_owned())
        .collect();
    found.sort();
    assert_eq!(found, DESERVED.map(|(name, _)| name));
}

/// §11.3 is §11.2 with names for the numbers: the module gets the same bytes.
#[test]
fn symbolic_constants_change_no_byte() {
    assert_eq!(instructions(&listing("tmcm_1311_11_3")), instructions(&listing("tmcm_1311_11_2")));
}

/// §5.6.5 gives the timer interrupt twice, and says that only the numbers are replaced by names.
#[test]
fn the_names_of_interrupts_change_no_byte() {
    assert_eq!(instructions(&listing("tmcm_1311_5_6_5_names")), instructions(&listing("tmcm_1311_5_6_5")));
}

/// §11.4 prints AAP, which would write axis parameter 42 of a motor 2; its comment and the text above it mean AGP, and that
/// is what the assembler suggests.
#[test]
fn the_slip_with_the_variable_is_mended_by_the_suggestion() {
    let text = text("tmcm_1311_11_4");
    let mended = assembled("mended", &as_suggested(&text));
    assert_eq!(codes(&mended), [""; 0]);
    assert_eq!(as_suggested(&text), text.replace("\nAAP", "\nAGP"));
}
