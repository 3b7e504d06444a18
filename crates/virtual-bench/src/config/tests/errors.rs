//! What is said about wrong files, word for word.

use insta::assert_snapshot;

use super::super::parse;
use super::table;

/// What is said about a file.
fn errors(text: &str) -> String {
    table(text, &parse(text).expect_err("a wrong file"))
}

/// What is said about a module with these lines.
fn in_module(lines: &str) -> String {
    errors(&format!("[[module]]\nkind = \"tmcm-1311\"\n{lines}"))
}

#[test]
fn form() {
    assert_snapshot!(errors("[[module]\nkind = \"tmcm-1311\"\n[supply]\nvoltage_v = \nvoltage_v = 3\n"));
}

#[test]
fn duplicate_keys() {
    assert_snapshot!(errors("[supply]\nvoltage_v = 3\nvoltage_v = 4\n"));
}

#[test]
fn unknown_keys() {
    assert_snapshot!(in_module(
        "adress = 1\n[module.load]\ntorqe_nm = 0.4\ncolour = 3\n[module.switches.left]\nat = 1\n[suply]\nvoltage = 3\n"
    ));
}

#[test]
fn wrong_types() {
    assert_snapshot!(in_module(
        "name = 3\naddress = \"1\"\n[module.load]\ninertia_kgm2 = \"0.1\"\nhard_stops = [1, 2]\n[module.encoder]\ncounts = 1.5\n\
         index = 1\n[module.motor]\npreset = 5718\n"
    ));
}

#[test]
fn out_of_range() {
    assert_snapshot!(in_module(
        "address = 256\ntemperature_c = 400\n[module.supply]\nvoltage_v = -3\nsource_resistance_ohm = 0\ncapacitance_f = 2200\n\
         [module.load]\nfriction_nm = nan\ninertia_kgm2 = inf\nviscous_nm_s_per_rad = 1e999\n[module.encoder]\ncounts = 0\n\
         [module.inputs]\nin_1 = 2\nain_0 = 4096\n"
    ));
}

#[test]
fn modules() {
    assert_snapshot!(errors(
        "[[module]]\n[[module]]\nkind = \"tmcm-1312\"\n[[module]]\nkind = \"tmcm-1640\"\nname = \"a.b\"\n\
         [[module]]\nkind = \"tmcm-1311\"\nname = \"load\"\n[[module]]\nkind = \"tmcm-1311\"\nname = \"m1\"\n"
    ));
}

#[test]
fn no_module() {
    assert_snapshot!(errors("[supply]\nvoltage_v = 24\n"));
}

#[test]
fn single_brackets() {
    assert_snapshot!(errors("[module]\nkind = \"tmcm-1311\"\n"));
}

#[test]
fn motors() {
    assert_snapshot!(in_module(
        "[module.motor]\npreset = \"QSH5718-51-28-100\"\nresistance_ohm = 1\n\
         [[module]]\nkind = \"tmcm-1311\"\n[module.motor]\nresistance_ohm = 1\nfull_steps = 201\n\
         [[module]]\nkind = \"tmcm-1311\"\n[module.motor]\npreset = \"QBL4208-61-04-013\"\n\
         [[module]]\nkind = \"tmcm-1311\"\n[module.motor]\npole_pairs = 4\n"
    ));
}

#[test]
fn what_a_module_for_brushless_motors_has_not() {
    assert_snapshot!(errors(
        "[[module]]\nkind = \"tmcm-1640\"\n[module.motor]\npreset = \"QSH5718-51-28-101\"\n[module.step_dir]\nenable = 1\n\
         [module.switches]\nhome.at_turns = 1\nright.at_turns = 1\n[module.inputs]\nin_0 = 1\nin_2 = 1\n\
         [module.halls]\noffset_deg = 400\ninverted = 1\noffset = 3\n\
         [[module]]\nkind = \"tmcm-1640\"\n[module.motor]\nholding_torque_nm = 1\n\
         [[module]]\nkind = \"tmcm-1640\"\n[module.motor]\nrated_current_a = 1\n\
         [[module]]\nkind = \"tmcm-1640\"\n[module.motor]\npole_pairs = 4\ntorque_constant_nm_per_a = 0.001\n\
         line_resistance_ohm = 0.7\nline_inductance_h = 1e-3\nrated_current_a = 3\nrotor_inertia_kgm2 = 5e-6\n\
         [[module]]\nkind = \"tmcm-1311\"\n[module.halls]\n\
         [[wire]]\nfrom = \"m2.output.0\"\nto = \"m1.input.0\"\n"
    ));
}

#[test]
fn figures_that_no_physics_can_follow() {
    assert_snapshot!(in_module(
        "[module.motor]\nrated_current_a = 2\nresistance_ohm = 100\ninductance_h = 1e-3\nholding_torque_nm = 0.5\n\
         detent_torque_nm = 0.6\nrotor_inertia_kgm2 = 1e-5\n"
    ));
}

#[test]
fn loads() {
    assert_snapshot!(in_module(
        "[module.load]\ntorque_nm = 0.4\ntorque = { by = \"angle\", points = [[0, 1], [0, 2], [3], 4, [5, 1000]] }\n\
         hard_stops = { low_turns = 1, high_turns = -1 }\n\
         [[module]]\nkind = \"tmcm-1311\"\n[module.load]\ntorque = { points = [] }\nhard_stops = {}\n\
         [[module]]\nkind = \"tmcm-1311\"\n[module.load]\ntorque = { by = \"time\", points = [[0, 1], [2, 0]], period = 1 }\n"
    ));
}

#[test]
fn switches() {
    assert_snapshot!(in_module(
        "[module.switches]\nleft = {}\nright = { at_turns = 1, side = \"belo\" }\n\
         home = { at_turns = 0, side = \"above\", width_turns = 0.1, bounce_ms = -1 }\nmiddle = { at_turns = 0 }\n\
         [module.inputs]\nin_0 = 1\nin_1 = 1\n"
    ));
}

#[test]
fn wires() {
    assert_snapshot!(in_module(
        "[module.inputs]\nin_2 = 1\n[[module]]\nkind = \"tmcm-1311\"\n[module.switches]\nhome.at_turns = 1\n\
         [[wire]]\nfrom = \"m1.input.0\"\nto = \"m2.input.0\"\n\
         [[wire]]\nfrom = \"m1.output.8\"\nto = \"m3.input.1\"\n\
         [[wire]]\nfrom = \"output.1\"\nto = \"m1.input.2\"\n\
         [[wire]]\nfrom = \"m2.output.1\"\nto = \"m1.input.3\"\n\
         [[wire]]\nfrom = \"m2.output.2\"\nto = \"m1.input.3\"\n\
         [[wire]]\nto = \"m2.input.1\"\ncolour = \"red\"\n"
    ));
}

#[test]
fn step_direction() {
    assert_snapshot!(in_module(
        "[module.step_dir]\nfrequency_hz = 1e7\npulses = 1.5\nenable = true\nfrequency = 3\n\
         [[module]]\nkind = \"tmcm-1311\"\nname = \"step_dir\"\n[module.step_dir]\nfrequency_hz = nan\npulses = -1\nenable = 2\n\
         [[event]]\nat = 1\nset = { \"m1.step_dir.frequency_hz\" = inf, \"m1.step_dir.pulses\" = \"many\", \"m2.step_dir.enable\" = true }\n"
    ));
}

#[test]
fn events() {
    assert_snapshot!(in_module(
        "[[event]]\n[[event]]\nat = \"1.5\"\nset = { \"load.torqe_nm\" = 1, \"m2.power\" = \"off\" }\n\
         [[event]]\nat = -1\nset = { \"fault.coil_open\" = \"c\", power = true }\n\
         [[event]]\nat = \"1 hour\"\nset = [1]\n\
         [[event]]\nat = [1]\nset = { \"input.9\" = 1, load = 3, a.b.c.d.e.f.g = 1 }\n"
    ));
}

#[test]
fn buses() {
    assert_snapshot!(in_module("[bus]\nmodules_hear_replies = 1\nmodules_hear = true\n"));
}
