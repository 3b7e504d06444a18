//! Sessions of the command line: what is typed and what is printed stand in `tests/cmd/*.md`, the README
//! and the page on host tools.

#[test]
fn sessions() {
    trycmd::TestCases::new().case("tests/cmd/*.md").case("../../README.md").case("../../docs/host-tools.md");
}
