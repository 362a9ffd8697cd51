//! Links that read files and pipes.

use asphera_transport::FileSettings;

use super::*;
use crate::station::Framing;

fn station(link: &str, settings: &str) -> Result<Config, Problems> {
    let text = format!(
        "[station]\nname = \"file\"\n[link.a]\nkind = \"file\"\n{link}\n\
         [device.z]\ndriver = \"described\"\nlink = \"a\"\n[device.z.settings]\n{settings}\n\
         [[device.z.settings.field]]\nname = \"z\"\ncolumn = 1\nunit = \"mm\"\n\
         [sync]\ndevices = [\"z\"]\n\
         [kinematics]\nkind = \"cartesian\"\nx = {{ constant_mm = 0 }}\n\
         y = {{ constant_mm = 0 }}\nz = {{ device = \"z\", channel = \"z\" }}\n\
         [nominal.surface]\nkind = \"plane\"\n"
    );
    Config::parse("bench/station.toml", &text)
}

fn endpoint(link: &str) -> Endpoint {
    let config = station(link, "").unwrap();
    assert_eq!((config.links[0].kind, &config.links[0].framing), ("file", &Framing::File));
    config.links[0].endpoint.clone()
}

fn keys(config: Result<Config, Problems>) -> Vec<String> {
    config.unwrap_err().0.into_iter().map(|problem| problem.key).collect()
}

#[test]
fn files_are_found_from_the_folder_of_the_configuration() {
    let file = |path: &str, follow, from_end| {
        Endpoint::File(FileSettings { path: path.into(), follow, from_end })
    };
    assert_eq!(endpoint("path = \"a.csv\""), file("bench/a.csv", false, false));
    assert_eq!(endpoint("path = \"/run/a\"\nfollow = true"), file("/run/a", true, true));
    assert_eq!(
        endpoint("path = \"a\"\nfollow = true\nfrom = \"begin\""),
        file("bench/a", true, false)
    );
    assert_eq!(endpoint("path = \"-\""), file("-", false, false));
}

#[test]
fn keys_that_do_not_fit_and_devices_that_ask_are_refused() {
    assert_eq!(keys(station("", "")), ["link.a.path"]);
    assert_eq!(keys(station("path = \"a\"\nfrom = \"end\"", "")), ["link.a.from"]);
    assert_eq!(keys(station("path = \"-\"\nfollow = true", "")), ["link.a.follow"]);
    assert_eq!(keys(station("path = \"a\"\nbaud_bd = 9600", "")), ["link.a.baud_bd"]);
    for settings in ["poll = { ask = 'M' }", "on_start = ['GO']"] {
        let problems = station("path = \"a\"", settings).unwrap_err();
        let found: Vec<_> = problems.0.iter().map(|problem| problem.key.as_str()).collect();
        assert_eq!(found, ["device.z.link"]);
        assert!(problems.to_string().contains("a, a file or pipe that answers nothing"));
    }
}
