//! NMEA 0183 and MOOS logs: times, channels, what is left out.

use seatrial_core::Sample;
use seatrial_logs::{ChannelChoice, Fault, Format, LogReader, Quantity, ReadError, Unit, open};

fn read(text: &str) -> Result<(LogReader, Vec<Sample<f64>>), ReadError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log");
    std::fs::write(&path, text).unwrap();
    let mut reader = open(&path, &ChannelChoice::default())?;
    let samples = reader.by_ref().collect::<Result<_, _>>()?;
    Ok((reader, samples))
}

fn with_checksum(sentence: &str) -> String {
    let sum = sentence.bytes().fold(0, |sum, byte| sum ^ byte);
    format!("${sentence}*{sum:02X}")
}

/// A doublet: heading every 0.1 s, rudder 10 ms before it, speed every second.
fn sentences(time: impl Fn(u32) -> String) -> String {
    let mut text = String::new();
    for k in 0..100 {
        let rudder = if k % 20 < 10 { 12.5 } else { -12.5 };
        let heading = (355.0 + 0.2 * f64::from(k)) % 360.0;
        let before = time(k);
        for sentence in [
            format!("IIRSA,{rudder:.1},A,,V"),
            format!("HEHDT,{heading:.1},T"),
            format!("TIROT,{:.1},A", 6.0 * rudder),
        ] {
            text += &format!("{before}{}\r\n", with_checksum(&sentence));
        }
        if k % 10 == 0 {
            text += &format!("{before}{}\r\n", with_checksum("VWVHW,,T,,M,4.0,N,7.4,K"));
        }
    }
    text
}

/// Loggers write the units in a row of their own.
#[test]
fn io_a_row_of_units_under_the_names() {
    for units in ["s,deg,deg,kn", "[s],[deg],[deg],[kn]"] {
        let mut text = format!("time,heading,rudder,speed\n{units}\n");
        for k in 0..100 {
            text += &format!("{:.1},{:.1},{},4.0\n", 0.1 * f64::from(k), 0.2 * f64::from(k), k % 7);
        }
        let (reader, samples) = read(&text).unwrap();
        assert_eq!(reader.description().warnings, [""; 0]);
        assert_eq!(samples.len(), 100);
        assert_eq!(samples[6].rudder_rad, 6.0_f64.to_radians());
        let speed = samples[0].surge_speed_m_s.unwrap();
        assert!((speed - 4.0 * 1852.0 / 3600.0).abs() < 1e-12);
    }
}

#[test]
fn io_a_speed_over_ground_without_a_unit_is_doubted() {
    let mut text = String::from("time_s,heading_deg,rudder_deg,sog\n");
    for k in 0..100 {
        text += &format!("{:.1},{:.1},{},4.0\n", 0.1 * f64::from(k), 0.2 * f64::from(k), k % 7);
    }
    let (reader, _) = read(&text).unwrap();
    let warnings = &reader.description().warnings;
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].starts_with("speed has no unit"), "{warnings:?}");
}

/// Positions tell the unit of a speed; what is assumed without them is said.
#[test]
fn io_positions_tell_the_unit_of_a_speed() {
    let log = |m_s_per_number: f64, has_positions: bool| {
        let mut text = String::from("time_s,heading_deg,rudder_deg,speed,north_m,east_m\n");
        for k in 0..200 {
            let way_m = 6.0 * m_s_per_number * 0.1 * f64::from(k);
            let [north, east] = match has_positions {
                true => [0.6 * way_m, 0.8 * way_m].map(|m| format!("{m:.3}")),
                false => Default::default(),
            };
            let row = [0.1 * f64::from(k), 0.2 * f64::from(k)];
            text += &format!("{:.1},{:.1},{},6.0,{north},{east}\n", row[0], row[1], k % 7);
        }
        let (reader, samples) = read(&text).unwrap();
        let warnings = reader.description().warnings.join("\n");
        (samples[0].surge_speed_m_s.unwrap(), warnings)
    };
    for (m_s, said) in [
        (1.0, "taken as m/s, at which"),
        (1852.0 / 3600.0, "taken as kn, at which"),
        (1.0 / 3.6, "taken as km/h, at which"),
    ] {
        let (speed_m_s, warnings) = log(m_s, true);
        assert!((speed_m_s - 6.0 * m_s).abs() < 1e-9, "{speed_m_s}");
        assert!(warnings.contains(said), "{warnings}");
    }
    let (speed_m_s, warnings) = log(0.5, false);
    assert_eq!(speed_m_s, 6.0);
    assert!(warnings.contains("--unit speed=kn"), "{warnings}");
}

/// A compass and a satellite compass in sentences of their own, and two rudders: what is taken is said.
#[test]
fn io_rivals_in_other_sentences_are_told() {
    let time = |k: u32| format!("{:.3},", 1_780_883_460.0 + f64::from(k) * 0.1);
    let mut text = sentences(time);
    for k in 0..50 {
        let compass = with_checksum(&format!("HCHDM,{:.1},M", 3.0 + 0.2 * f64::from(k)));
        let twins = with_checksum("IIRSA,1.0,A,1.5,A");
        text += &format!("{0}{compass}\r\n{0}{twins}\r\n", time(100 + k));
    }
    let (reader, _) = read(&text).unwrap();
    let warnings = reader.description().warnings.join("\n");
    for said in ["`HDT.heading_deg` is taken", "HDM.heading_deg", "RSA.port_deg"] {
        assert!(warnings.contains(said), "{warnings}");
    }
}

/// Two compasses of one log are two channels, of which the one with more sentences is proposed.
#[test]
fn io_two_talkers_are_two_channels() {
    let time = |k: u32| format!("{:.3},", 1_780_883_460.0 + f64::from(k) * 0.1);
    let mut text = sentences(time);
    for k in 0..50 {
        let heading = (3.0 + 0.2 * f64::from(k)) % 360.0;
        let sentence = with_checksum(&format!("HCHDT,{heading:.1},T"));
        text += &format!("{}{sentence}\r\n", time(100 + k));
    }
    let (reader, samples) = read(&text).unwrap();
    assert_eq!(samples.len(), 100);
    let names = &reader.description().columns;
    for name in ["HE.HDT.heading_deg", "HC.HDT.heading_deg"] {
        assert!(names.iter().any(|column| column == name), "{names:?}");
    }
    let warnings = &reader.description().warnings;
    let is_said = |text: &String| text.contains("2 instruments send HDT") && text.contains("`HE.");
    assert!(warnings.iter().any(is_said), "{warnings:?}");
}

#[test]
fn io_nmea_0183_with_times_before_the_sentences() {
    for time in [
        |k: u32| format!("2026-06-08T01:51:{:06.3}Z ", f64::from(k) * 0.1),
        |k: u32| format!("{:.3},", 1_780_883_460.0 + f64::from(k) * 0.1),
        |k: u32| format!("{} ", 1_780_883_460_000_u64 + u64::from(k) * 100),
        |k: u32| format!("\\c:{:.1}*00\\", 1_780_883_460.0 + f64::from(k) * 0.1),
    ] {
        let (reader, samples) = read(&sentences(time)).unwrap();
        assert_eq!(reader.description().format, Format::Nmea0183);
        assert!(reader.warnings().is_empty(), "{:?}", reader.warnings());
        assert_eq!(samples.len(), 100);
        for (k, sample) in samples.iter().enumerate() {
            // Epochs in s are doubles of 0.2 us.
            assert!((sample.time_s - 0.1 * k as f64).abs() < 1e-6);
            let expected = if k % 20 < 10 { 12.5_f64 } else { -12.5 };
            assert_eq!(sample.rudder_rad, expected.to_radians());
            let rate = sample.yaw_rate_rad_s.unwrap();
            assert!((rate - (6.0 * expected / 60.0).to_radians()).abs() < 1e-15);
            assert!((sample.surge_speed_m_s.unwrap() - 4.0 * 1852.0 / 3600.0).abs() < 1e-12);
        }
        assert!((samples[99].heading_rad - 14.8_f64.to_radians()).abs() < 1e-12);
    }
}

#[test]
fn io_nmea_0183_times_come_from_rmc_over_midnight() {
    let mut text = String::new();
    for k in 0..20_u32 {
        let second = (86_390 + k) % 86_400;
        let clock = format!("{:02}{:02}{:02}.00", second / 3600, second / 60 % 60, second % 60);
        let position = match k {
            0 => format!("GPRMC,{clock},A,,,,,4.0,90.0,310126,,"),
            _ => format!("GPGGA,{clock},,,,,1,8,,,,,,,"),
        };
        for sentence in [position, format!("IIRSA,{k}.0,A,,V"), format!("HEHDT,{k}.0,T")] {
            text += &format!("{}\n", with_checksum(&sentence));
        }
    }
    let (reader, samples) = read(&text).unwrap();
    assert_eq!(samples.len(), 20);
    assert!(samples.windows(2).all(|p| p[1].time_s - p[0].time_s == 1.0));
    let start = reader.description().start_utc.as_deref();
    assert_eq!(start, Some("2026-01-31T23:59:50Z"));
    assert!(reader.warnings().iter().any(|w| w.contains("RMC")));
}

#[test]
fn io_nmea_0183_wrong_checksums_are_left_out_and_counted() {
    let text =
        sentences(|k| format!("{} ", f64::from(k) * 0.1)).replacen("HEHDT,356.0", "HEHDT,358.0", 1);
    let (reader, samples) = read(&text).unwrap();
    assert_eq!(samples.len(), 99);
    let warnings = reader.warnings();
    assert!(warnings.iter().any(|w| w.contains("in 1 places")), "{warnings:?}");
}

#[test]
fn io_nmea_0183_without_any_time_is_refused() {
    let Err(error) = read(&sentences(|_| String::new())) else {
        panic!("a log without times was read");
    };
    assert!(matches!(&error.fault, Fault::NotLogged { quantity: Quantity::Time, .. }), "{error}");
}

#[test]
fn io_moos_variables_are_found() {
    let mut text =
        String::from("%%%%%%%%%%%%%\n%% LOG FILE: run\n%% LOGSTART 1780883460.1\n%%%%%%%%%%%%%\n");
    for k in 0..50 {
        let time_s = f64::from(k) * 0.25;
        text += &format!("{time_s:.3}   NAV_HEADING   pNav   {}\n", 90.0 + f64::from(k));
        text += &format!("{time_s:.3}   NAV_SPEED     pNav   1.25\n");
        text += &format!("{time_s:.3}   DESIRED_RUDDER  pHelm:PID  {}\n", k % 20 - 10);
        text += &format!("{time_s:.3}   MODE  pHelm  SURVEYING and more words\n");
    }
    let (reader, samples) = read(&text).unwrap();
    let description = reader.description();
    assert_eq!(description.format, Format::Alog);
    let rudder = description.channels.iter().find(|c| c.quantity == Quantity::Rudder);
    assert_eq!(rudder.map(|c| (c.column.as_str(), c.unit)), Some(("DESIRED_RUDDER", Unit::Degree)));
    assert_eq!(samples.len(), 50);
    assert_eq!(samples[30].heading_rad, 120_f64.to_radians());
    assert_eq!(samples[30].surge_speed_m_s, Some(1.25));
    assert_eq!(samples[30].rudder_rad, 0.0);
}
