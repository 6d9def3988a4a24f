//! One run in the layouts that recorders, loggers and databases write: each gives the samples of the run.

use std::fmt::Write;

use seatrial_logs::{ChannelChoice, Fault, LogReader, Quantity, UnitSource, open};

/// Noon of 1 May 2024 in seconds since 1970.
const START_S: f64 = 1_714_564_800.0;

/// A row of the run: time in s, heading and rudder in degrees.
type Row = (f64, f64, f64);

/// Two minutes at 10 Hz, with a heading that passes north.
fn run() -> Vec<Row> {
    (0..1200)
        .map(|k| {
            let time_s = 0.1 * f64::from(k);
            let heading = 350.0 + 40.0 * (0.2 * time_s).sin();
            (time_s, heading.rem_euclid(360.0), 10.0 * (0.2 * time_s).cos())
        })
        .collect()
}

fn text(head: &str, row: impl Fn(Row) -> String) -> String {
    run().into_iter().fold(head.to_owned(), |text, of| text + &row(of) + "\n")
}

fn opened(bytes: &[u8], folder: &tempfile::TempDir) -> Result<LogReader, Fault> {
    let path = folder.path().join("log");
    std::fs::write(&path, bytes).unwrap();
    open(&path, &ChannelChoice::default()).map_err(|error| error.fault)
}

/// Reads the run: times to 15 ms, since recorders stamp one channel behind the other and days have eight decimals; headings to
/// a tenth of a degree; rudders to what they move in between, 0.2 degrees.
#[track_caller]
fn assert_is_the_run(name: &str, bytes: &[u8]) -> Vec<String> {
    let folder = tempfile::tempdir().unwrap();
    let mut reader = opened(bytes, &folder).unwrap_or_else(|fault| panic!("{name}: {fault}"));
    let read: Result<Vec<_>, _> = reader.by_ref().collect();
    let read = read.unwrap_or_else(|error| panic!("{name}: {error}"));
    let run = run();
    let missing = run.len() - read.len();
    // A first row that lacks a channel is left out, and a last time has none behind it.
    assert!(missing <= 10, "{name}: {missing} rows are missing");
    let begin = run.len() - read.len();
    let is_cut_at_the_end = (read[0].heading_rad.to_degrees() - run[0].1).abs() < 0.1;
    let from = if is_cut_at_the_end { 0 } else { begin };
    for (sample, row) in read.iter().zip(&run[from..]) {
        let late_s = (sample.time_s - read[0].time_s) - (row.0 - run[from].0);
        let turned = (sample.heading_rad - row.1.to_radians()).sin().to_degrees();
        let moved = sample.rudder_rad.to_degrees() - row.2;
        let is_same = late_s.abs() < 0.015 && turned.abs() < 0.1 && moved.abs() < 0.25;
        assert!(is_same, "{name}: {sample:?} for {row:?}");
    }
    let warnings = reader.description().warnings.clone();
    [warnings, reader.warnings()].concat()
}

/// Hours, minutes and seconds of the clock, with room for rounding.
fn clock(time_s: f64) -> (u32, u32, f64) {
    let tenths = (10.0 * time_s).round() as u32;
    (12, tenths / 600, f64::from(tenths % 600) / 10.0)
}

fn hhmmss(time_s: f64) -> String {
    let (hours, minutes, seconds) = clock(time_s);
    format!("{hours:02}{minutes:02}{seconds:06.3}")
}

fn iso(time_s: f64) -> String {
    let (hours, minutes, seconds) = clock(time_s);
    format!("2024-05-01T{hours:02}:{minutes:02}:{seconds:06.3}Z")
}

#[test]
fn io_times_in_parts_in_digits_and_of_other_eras_are_read() {
    let angles = |heading: f64, rudder: f64| format!("{heading:.3},{rudder:.2}");
    let of = |names: &str, time: &dyn Fn(f64) -> String| {
        let head = format!("{names},heading_deg,rudder_deg\n");
        text(&head, |(t, h, d)| format!("{},{}", time(t), angles(h, d)))
    };
    let parts = |t: f64| {
        let (hours, minutes, seconds) = clock(t);
        let tenths = (10.0 * seconds).round() as u32;
        (hours, minutes, tenths / 10, 100 * (tenths % 10))
    };
    for (names, written) in [
        (
            "hour,min,sec",
            of("hour,min,sec", &|t| {
                let (hours, minutes, seconds) = clock(t);
                format!("{hours},{minutes},{seconds:.1}")
            }),
        ),
        (
            "seconds,milliseconds",
            of("seconds,milliseconds", &|t| {
                let tenths = (10.0 * t).round() as u32;
                format!("{},{}", tenths / 10, 100 * (tenths % 10))
            }),
        ),
        ("t_sec,t_ms", of("t_sec,t_ms", &|t| format!("{},{:.0}", (t + 1e-9).floor(), 1e3 * t))),
        (
            "YY,MM,DD,hh,mi,ss,ms",
            of("YY,MM,DD,hh,mi,ss,ms", &|t| {
                let (hours, minutes, seconds, milliseconds) = parts(t);
                format!("24,5,1,{hours},{minutes},{seconds},{milliseconds}")
            }),
        ),
        ("date,utc", of("date,utc", &|t| format!("010524,{}", hhmmss(t)))),
        ("hhmmssmmm", of("time", &|t| hhmmss(t).replace('.', ""))),
        ("yyyymmdd_hhmmss", of("time", &|t| format!("20240501_{}", hhmmss(t)))),
        (
            "ms since 1904",
            of("timestamp", &|t| format!("{:.0}", 1e3 * (START_S + 2_082_844_800.0 + t))),
        ),
        (
            "ms since 1601",
            of("timestamp", &|t| format!("{:.0}", 1e3 * (START_S + 11_644_473_600.0 + t))),
        ),
        ("hundredths since 1970", of("timestamp", &|t| format!("{:.0}", 1e2 * (START_S + t)))),
        ("ts", of("ts", &|t| format!("{:.1}", START_S + t))),
    ] {
        assert_is_the_run(names, written.as_bytes());
    }
}

/// The count of microseconds since 1601 of today is that of 100 ns since 1970 of 2012.
#[test]
fn io_a_count_of_two_eras_is_no_date() {
    let since_1601_s = START_S + 11_644_473_600.0;
    let log = text("timestamp,heading_deg,rudder_deg\n", |(t, h, d)| {
        format!("{:.0},{h:.3},{d:.2}", 1e6 * (since_1601_s + t))
    });
    let folder = tempfile::tempdir().unwrap();
    let reader = opened(log.as_bytes(), &folder).unwrap();
    let found = reader.description();
    assert_eq!(found.start_utc, None);
    assert_eq!(found.channels[0].unit_source, UnitSource::Assumed);
    let doubts = found.warnings.join("\n");
    assert!(doubts.contains("us since 1601") && doubts.contains("--unit time=UNIT"), "{doubts}");
}

#[test]
fn io_tables_are_read_whatever_stands_before_and_in_them() {
    let plain = |head: &str| text(head, |(t, h, d)| format!("{t:.1},{h:.3},{d:.2}"));
    let names = "time_s,heading_deg,rudder_deg\n";
    let degrees = |heading: f64| {
        let seconds = (3600.0 * heading).round() as u32;
        (seconds / 3600, seconds / 60 % 60, seconds % 60)
    };
    let filled = |none: &str| {
        let head = "time_s,heading_deg,rudder_deg\n";
        text(head, |(t, h, d)| format!("{t:.3},{h:.3},{none}\n{:.3},{none},{d:.2}", t + 0.001))
    };
    let heading = |(t, h, _): Row| format!(",,0,{},{h:.3},heading_deg,boat", iso(t));
    let rudder = |(t, _, d): Row| format!(",,1,{},{d:.3},rudder_deg,boat", iso(t));
    let names_of_influx = "#group,false,false\n,result,table,_time,_value,_field,_measurement\n";
    let grafana = |(t, h, d): Row| {
        let (time, heading, rudder) = (iso(t), h.to_radians(), d.to_radians());
        format!(
            "\"navigation.headingTrue\";\"{time}\";{heading:.5}\n\"steering.rudderAngle\";\"{time}\";{rudder:.5}"
        )
    };
    for (name, log) in [
        ("per cent signs", plain("%% exported\n% t [s], psi [deg], delta [deg]\n")),
        (
            "per cent signs before names and units",
            plain("% exported\n% time, heading, rudder\n% s, deg, deg\n"),
        ),
        (
            "a name that is cut off",
            text("time,name,value\n", |(t, h, d)| {
                format!("{0},heading_deg,{h:.3}\n{0},rudder_deg,{d:.2}", iso(t))
            }) + "2024-05-01T13:00:00Z,rudder,1.0",
        ),
        (
            "degrees to starboard and port",
            text("Time (s);Heading;Rudder\n", |(t, h, d)| {
                let side = if d < 0.0 { 'P' } else { 'S' };
                format!("{t:.1};{h:.3}°;{:.2}° {side}", d.abs())
            }),
        ),
        ("garbage", plain(&format!("\0\u{7f}\u{1}boot\n\n***\n{names}"))),
        (
            "degrees, minutes, seconds",
            text("time_s,heading,rudder_deg\n", |(t, h, d)| {
                let (degrees, minutes, seconds) = degrees(h);
                format!("{t:.1},{degrees}°{minutes:02}'{seconds:02}'',{d:.2}")
            }),
        ),
        (
            "sides",
            text("time_s,heading_deg,rudder (deg)\n", |(t, h, d)| {
                let side = if d < 0.0 { "P" } else { "S" };
                format!("{t:.1},{h:.3},{side}{:.2}", d.abs())
            }),
        ),
        ("empty cells", filled("")),
        ("NaN for no value", filled("NaN")),
        ("InfluxDB", text(names_of_influx, heading) + "\n" + &text(names_of_influx, rudder)),
        ("Grafana", text("\"Series\";\"Time\";\"Value\"\n", grafana)),
        (
            "InfluxDB's lines",
            text("", |(t, h, d)| {
                let ns = 1e9 * (START_S + t);
                format!(
                    "boat,host=pi\\ 4 heading_deg={h:.3},rudder_deg={d:.2},fix=3i,mode=\"a b\" {ns:.0}"
                )
            }),
        ),
        (
            "InfluxDB's lines of one value",
            text("", |(t, h, d)| {
                let ms = 1e3 * (START_S + t);
                format!("heading_deg value={h:.3} {ms:.0}\nrudder_deg value={d:.2} {ms:.0}")
            }),
        ),
        (
            "key=value",
            text("", |(t, h, d)| format!("INFO t_s={t:.1}; heading_deg={h:.3}; rudder_deg={d:.2}")),
        ),
        (
            "key: value",
            text("", |(t, h, d)| format!("t_s: {t:.1}, heading_deg: {h:.3}\trudder_deg:{d:.2}")),
        ),
        (
            "key=value behind a time",
            text("", |(t, h, d)| {
                format!("{} heading={h:.3}deg rudder={d:.2}deg", iso(t).replace('T', " "))
            }),
        ),
        ("names again", plain(names).replace("\n60.0,", &format!("\n{names}60.0,"))),
        (
            "topics without names",
            text("", |(t, h, d)| {
                let time_s = START_S + t;
                format!("{time_s:.3} boat/heading_deg {h:.3}\n{time_s:.3} boat/rudder_deg {d:.2}")
            }),
        ),
        (
            "Grafana's labels",
            text(
                "Time,\"navigation.headingTrue.mean {context: self}\",\"steering.rudderAngle {context: self}\"\n",
                |(t, h, d)| format!("{},{:.5},{:.5}", iso(t), h.to_radians(), d.to_radians()),
            ),
        ),
        (
            "units behind values",
            text("Time,Series,Value\n", |(t, h, d)| {
                format!("{0},Heading,{h:.3}°\n{0},Rudder,{d:.2}°", iso(t))
            }),
        ),
        (
            "units beside values",
            text("ts;sensor;reading;unit\n", |(t, h, d)| {
                format!("{0};heading;{h:.3};deg\n{0};rudder;{d:.2};deg", iso(t))
            }),
        ),
        (
            "states of entities",
            text("entity_id,state,last_changed\n", |(t, h, d)| {
                format!("sensor.heading,{h:.3},{0}\nsensor.rudder,{d:.2},{0}", iso(t))
            }),
        ),
        (
            "a date and a French hour",
            text("Date,Heure,Cap,Barre\n", |(t, h, d)| {
                format!("01/05/2024,{},{h:.3},{d:.2}", &iso(t)[11..23])
            }),
        ),
        (
            "a zone behind the time",
            text("time,heading_deg,rudder_deg\n", |(t, h, d)| {
                format!("{} UTC,{h:.3},{d:.2}", iso(t)[..23].replace('T', " "))
            }),
        ),
        (
            "right and left",
            text("time_s,heading,rudder\n", |(t, h, d)| {
                let side = if d < 0.0 { 'L' } else { 'R' };
                format!("{t:.1},{h:.3}°M,{:.2}°{side}", d.abs())
            }),
        ),
        (
            "tenths and hundredths by name",
            text("time_s,heading_x100,rudder (0.1 deg)\n", |(t, h, d)| {
                format!("{t:.1},{:.0},{:.1}", 100.0 * h, 10.0 * d)
            }),
        ),
        (
            "a remark behind a unit",
            text("time_s,heading_deg (gyro),rudder_deg (starboard positive)\n", |(t, h, d)| {
                format!("{t:.1},{h:.3},{d:.2}")
            }),
        ),
        (
            "seconds of a day",
            text("Year,DOY,SecondsOfDay,heading_deg,rudder_deg\n", |(t, h, d)| {
                format!("2024,122,{:.1},{h:.3},{d:.2}", 43_200.0 + t)
            }),
        ),
        (
            "a sine and a cosine",
            text("time_s,sin(heading),cos(heading),rudder_deg\n", |(t, h, d)| {
                let (sine, cosine) = h.to_radians().sin_cos();
                format!("{t:.1},{sine:.5},{cosine:.5},{d:.2}")
            }),
        ),
        (
            "objects of JSON in lines",
            text("", |(t, h, d)| {
                format!(
                    "{{\"timestamp\": \"{}\", \"imu\": {{\"heading_deg\": {h:.3}, \"note\": \"a }}\"}}, \"rudder_deg\": {d:.2}}}",
                    iso(t)
                )
            }),
        ),
        (
            "objects of JSON in an array",
            format!(
                "[{}]",
                run()
                    .iter()
                    .map(|(t, h, d)| format!(
                        "{{\"time_s\":{t:.1},\"heading_deg\":{h:.3},\"rudder_deg\":{d:.2}}}"
                    ))
                    .collect::<Vec<_>>()
                    .join(",")
            ),
        ),
        (
            "mavlogdump's JSON",
            text("", |(t, h, d)| {
                let time_s = START_S + t;
                let meta = |name: &str| {
                    format!(
                        "{{\"meta\":{{\"type\":\"{name}\",\"timestamp\":{time_s:.3}}},\"data\":"
                    )
                };
                format!(
                    "{}{{\"heading_deg\":{h:.3}}}}}\n{}{{\"rudder_deg\":{d:.2},\"port\":0}}}}",
                    meta("VFR_HUD"),
                    meta("RUDDER")
                )
            }),
        ),
        (
            "mavlogdump's text",
            text("", |(t, h, d)| {
                let time = iso(t).replace(['T', 'Z'], " ");
                let time = time.trim_end();
                format!(
                    "{time}: VFR_HUD {{heading_deg : {h:.3}, alt : 1.5}}\n{time}: RUDDER {{port : 0, rudder_deg : {d:.2}}}"
                )
            }),
        ),
        (
            "seconds since, remarks in brackets, actual angles",
            text(
                "time (seconds since 01/01/1970),Heading (M) (deg),RUDDER_ACT [deg],RUDDER_ORD [deg]\n",
                |(t, h, d)| format!("{:.1},{h:.3},{d:.2},{:.1}", START_S + t, 2.0 * d),
            ),
        ),
        (
            "data of a topic",
            text("__time,/imu/heading_deg,/rudder/data\n", |(t, h, d)| {
                format!("{:.3},{h:.3},\n{:.3},,{d:.2}", START_S + t, START_S + t + 0.001)
            }),
        ),
        (
            "a quaternion in a list",
            text("time_s,q[0],q[1],q[2],q[3],rudder_deg\n", |(t, h, d)| {
                let half = 0.5 * h.to_radians();
                format!("{t:.1},{:.6},0,0,{:.6},{d:.2}", half.cos(), half.sin())
            }),
        ),
        (
            "a quaternion from w on",
            text("time_s,q0,q1,q2,q3,rudder_deg\n", |(t, h, d)| {
                let half = 0.5 * h.to_radians();
                format!("{t:.1},{:.6},0,0,{:.6},{d:.2}", half.cos(), half.sin())
            }),
        ),
        (
            "Expedition",
            text("!Boat,Utc,BSP,RudderFwd,HDG\n!boat,0,1,7,13\n!v12\n", |(t, h, d)| {
                format!("0,{:.8},7,{d:.2},13,{h:.2}", 45_413.5 + t / 86_400.0)
            }),
        ),
    ] {
        assert_is_the_run(name, log.as_bytes());
    }
}

/// Between the names of columns and the first numbers stand words, units and dashes; behind numbers, units.
#[test]
fn io_laboratories_and_databases_head_their_tables_with_more_than_names() {
    let tabs = |(t, h, d): Row| format!("{t:.3}\t{h:.3}\t{d:.2}");
    let bars = |(t, h, d): Row| format!(" {t:.3} | {h:.3} | {d:.2} ");
    let commas = |(t, h, d): Row| format!("{t:.3},{h:.3},{d:.2}");
    let of_labview = "LabVIEW Measurement\t\nWriter_Version\t2\n***End_of_Header***\t\n\nX_Dimension\tTime\tTime\t\n\
         ***End_of_Header***\t\t\t\nX_Value\tHeading (deg)\tRudder (deg)\tComment\n";
    let of_campbell = "\"TOA5\",\"CR1000\",\"CR1000\",\"1234\",\"CPU:boat.CR1\"\n\"TIMESTAMP\",\"RECORD\",\"Heading\",\"Rudder\"\n\
         \"TS\",\"RN\",\"deg\",\"deg\"\n\"\",\"\",\"Smp\",\"Smp\"\n";
    for (name, log) in [
        ("LabVIEW, without its comments", text(of_labview, tabs)),
        (
            "a logger of Campbell",
            text(of_campbell, |(t, h, d)| {
                format!("\"{}\",{},{h:.3},{d:.2}", iso(t), (10.0 * t).round())
            }),
        ),
        (
            "units in brackets, one of them none",
            text("timestamp\tstatus\tyaw\trudder\n(us)\t(na)\t(deg)\t(deg)\n", |(t, h, d)| {
                format!("{:.0}\t255\t{h:.3}\t{d:.2}", 1e6 * t)
            }),
        ),
        (
            "a table in Markdown",
            text("| time_s | heading_deg | rudder_deg |\n|---|---|---|\n", |row| {
                format!("|{}|", bars(row))
            }),
        ),
        (
            "psql",
            text(" time_s | heading_deg | rudder_deg\n--------+-------------+-----------\n", bars),
        ),
        (
            "a timetable of MATLAB",
            text("Time,Heading_deg,Rudder_deg\n", |(t, h, d)| format!("{t:.1} sec,{h:.3},{d:.2}")),
        ),
        ("topics of one field", text("__time,/imu/yaw_deg,/rudder_deg/data\n", commas)),
        (
            "names over two lines",
            text("\"Time\n(s)\",\"Heading\n(deg)\",\"Rudder\n(deg)\"\n", commas),
        ),
        ("a unit below its quantity", text("time,imu,servo\ns,heading_deg,rudder_deg\n", commas)),
        (
            "a time by its digits",
            text("hhmmss.sss,heading_deg,rudder_deg\n", |(t, h, d)| {
                format!("{},{h:.3},{d:.2}", hhmmss(t))
            }),
        ),
        (
            "a line of a program by its name",
            text("", |(t, h, d)| {
                format!("{} I boat: heading_deg={h:.3} rudder_deg={d:.2}", iso(t))
            }),
        ),
        ("seconds of GPS", text("Time (GPS s),Heading (deg),Rudder Angle (deg)\n", commas)),
    ] {
        assert_is_the_run(name, log.as_bytes());
    }
}

/// A name that comes again has its group before it, so that an option can name it.
#[test]
fn io_names_that_come_again_have_their_group() {
    let head = "Format Version,1.23\n,,Rotation,Position,Servo\nFrame,Time (s),Y,Y,rudder (deg)\n";
    let log = text(head, |(t, h, d)| format!("{:.0},{t:.1},{h:.3},1.0,{d:.2}", 10.0 * t));
    let folder = tempfile::tempdir().unwrap();
    let error = opened(log.as_bytes(), &folder).err().unwrap().to_string();
    assert!(error.contains("`Rotation Y`, `Position Y`"), "{error}");
}

/// A text copy of a DataFlash log and captures of sentences and frames are the logs that they hold, with check sums of their own.
#[cfg(all(feature = "parquet", feature = "mcap", feature = "rosbag2"))]
#[test]
fn io_copies_and_captures_are_the_logs_in_them() {
    let folder = tempfile::tempdir().unwrap();
    let read = |bytes: &[u8]| {
        let mut reader = opened(bytes, &folder).unwrap();
        let samples: Vec<_> = reader.by_ref().map(Result::unwrap).collect();
        let described = reader.description().format.to_string();
        (samples, described, reader.sha256().unwrap())
    };
    for (format, one, other) in [("dataflash", 0, 1), ("nmea0183", 2, 3)] {
        let seeds = crate::seeds::of(format);
        let [one, other] = [one, other].map(|at| read(&seeds[at]));
        assert_eq!(other.1, format);
        assert_ne!(one.2, other.2);
        assert_eq!(one.0.len(), other.0.len(), "{format}");
        for (a, b) in one.0.iter().zip(&other.0) {
            let late_s = (a.time_s - one.0[0].time_s) - (b.time_s - other.0[0].time_s);
            let is_same = late_s.abs() < 1e-6
                && (a.heading_rad - b.heading_rad).abs() < 1e-9
                && (a.rudder_rad - b.rudder_rad).abs() < 1e-9;
            assert!(is_same, "{format}: {a:?} {b:?}");
        }
        let path = folder.path().join("log");
        assert_eq!(other.2, seatrial_logs::sha256(&path).unwrap());
    }
    // Frames, whatever wrote them.
    let of_frames = crate::seeds::of("canboat");
    let of_socket = read(&of_frames[of_frames.len() - 1]);
    let of_differences = read(&of_frames[of_frames.len() - 2]);
    assert_eq!(of_socket.0.len(), of_differences.0.len());
    for (a, b) in of_socket.0.iter().zip(&of_differences.0) {
        let late_s = (a.time_s - of_socket.0[0].time_s) - (b.time_s - of_differences.0[0].time_s);
        assert!(late_s.abs() < 1e-6 && a.heading_rad == b.heading_rad, "{a:?} {b:?}");
    }
}

/// Two motors of which the second counts the other way are named with a minus.
#[test]
fn io_half_the_sum_of_two_columns_is_a_rudder() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log");
    for (unit, neutral, per_deg) in [("deg", 0.0, 1.0), ("pwm", 1500.0, 10.0)] {
        let of = |d: f64| neutral + per_deg * d;
        let log = text("time_s,heading_deg,port,starboard\n", |(t, h, d)| {
            format!("{t:.1},{h:.3},{},{}", of(d + 3.0), of(d - 3.0))
        });
        std::fs::write(&path, log).unwrap();
        let mut choice = ChannelChoice::default();
        let pair = ["port", "-starboard"].map(str::to_owned);
        choice.half_differences.insert(Quantity::Rudder, pair);
        choice.units.insert(Quantity::Rudder, unit.parse().unwrap());
        // 400 us are full rudder.
        choice.full_rudder_rad = (unit == "pwm").then(|| 40.0_f64.to_radians());
        let reader = open(&path, &choice).unwrap();
        let column = reader.description().channels.iter();
        let mut column = column.filter(|channel| channel.quantity == Quantity::Rudder);
        assert_eq!(column.next().unwrap().column, "(port + starboard) / 2");
        for (sample, row) in reader.zip(run()) {
            let moved = sample.unwrap().rudder_rad.to_degrees() - row.2;
            assert!(moved.abs() < 1e-9, "{unit}: {moved}");
        }
    }
}

/// A minute before one o'clock on a clock of twelve hours, and before midnight.
#[test]
fn io_a_clock_that_begins_again_goes_on() {
    let of_day = |from_s: f64, t: f64| {
        let tenths = (10.0 * (from_s + t)).round() as u32;
        let (hours, minutes) = (tenths / 36_000, tenths / 600 % 60);
        (hours, minutes, f64::from(tenths % 600) / 10.0)
    };
    let one = |t: f64| {
        let (hours, minutes, seconds) = of_day(46_740.0, t);
        format!("{:02}:{minutes:02}:{seconds:04.1}", (hours + 11) % 12 + 1)
    };
    let midnight = |t: f64| {
        let (hours, minutes, seconds) = of_day(86_340.0, t);
        format!("{:02}:{minutes:02}:{seconds:04.1}", hours % 24)
    };
    let of = |names: &str, time: &dyn Fn(f64) -> String| {
        let head = format!("{names},heading_deg,rudder_deg\n");
        text(&head, |(t, h, d)| format!("{},{h:.3},{d:.2}", time(t)))
    };
    let twelve = "12 h were added";
    for (name, written, warning) in [
        ("12 hours", of("time", &one), twelve),
        ("12 hours in digits", of("time", &|t| one(t).replace(':', "")), twelve),
        ("12 hours behind a date", of("time", &|t| format!("2024-05-01 {}", one(t))), twelve),
        ("12 hours beside a date", of("date,time", &|t| format!("2024-05-01,{}", one(t))), twelve),
        ("midnight", of("time", &midnight), "24 h were added"),
        (
            "midnight in columns",
            of("hour,minute,second", &|t| midnight(t).replace(':', ",")),
            "24 h were added",
        ),
        (
            "midnight behind dates with the month first",
            of("time", &|t| {
                let day = if t < 60.0 { 1 } else { 2 };
                format!("5/{day}/2024 {}", midnight(t))
            }),
            "30 days",
        ),
        (
            "a counter of 32 bits",
            of("micros", &|t| {
                let counts = 4_294_967_296.0 - 60e6 + 1e6 * t;
                format!("{:.0}", counts.rem_euclid(4_294_967_296.0))
            }),
            "as a counter that is full",
        ),
        (
            "a counter of 16 bits",
            of("t_ms", &|t| format!("{:.0}", (5536.0 + 1e3 * t).rem_euclid(65_536.0))),
            "as a counter that is full",
        ),
    ] {
        let warnings = assert_is_the_run(name, written.as_bytes()).join("\n");
        assert!(warnings.contains(warning), "{name}: {warnings}");
    }
    // A clock that was set back by ten hours did not begin again.
    let set_back = of("time", &|t| match t < 60.0 {
        true => one(t),
        false => format!("02:59:{:04.1}", t - 60.0),
    });
    let folder = tempfile::tempdir().unwrap();
    let mut reader = opened(set_back.as_bytes(), &folder).unwrap();
    let read: Result<Vec<_>, _> = reader.by_ref().collect();
    assert!(read.unwrap_err().to_string().contains("time goes back"));
}

/// A time of day says that it is in seconds, alone and beside a date; a number does not.
#[test]
fn io_a_time_of_day_states_its_unit() {
    let folder = tempfile::tempdir().unwrap();
    let source = |head: &str, time: &dyn Fn(f64) -> String| {
        let log = text(head, |(t, h, d)| format!("{},{h:.3},{d:.2}", time(t)));
        let reader = opened(log.as_bytes(), &folder).unwrap();
        let channels = &reader.description().channels;
        let of_time = channels.iter().find(|of| of.quantity == Quantity::Time);
        of_time.unwrap().unit_source
    };
    let of_day = |t: f64| iso(t)[11..23].to_owned();
    let angles = "heading_deg,rudder_deg\n";
    for (head, time, expected) in [
        ("time", &of_day as &dyn Fn(f64) -> String, UnitSource::Stated),
        ("date,time", &|t| "1/5/24,".to_owned() + &of_day(t), UnitSource::Stated),
        ("time", &|t| format!("{t:.1}"), UnitSource::Assumed),
    ] {
        assert_eq!(source(&format!("{head},{angles}"), time), expected, "{head}");
    }
}

#[test]
fn io_a_heading_that_wraps_at_no_known_turn_is_refused() {
    let log = text("time_s,heading,rudder_deg\n", |(t, _, d)| {
        // Two turns in points of the compass.
        format!("{t:.1},{:.3},{d:.2}", (0.6 * t).rem_euclid(32.0))
    });
    let folder = tempfile::tempdir().unwrap();
    let refused = opened(log.as_bytes(), &folder).err();
    assert!(matches!(refused, Some(Fault::ImplausibleValues { .. })), "{refused:?}");
}

/// A sentence with its checksum.
fn sentence(body: &str) -> String {
    let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
    format!("${body}*{sum:02X}")
}

fn fix(time_s: f64) -> String {
    let body = format!("GPRMC,{},A,5000.0000,N,00100.0000,W,6.0,120.0,010524,,,A", hhmmss(time_s));
    sentence(&body)
}

/// Sentences of a heading and a rudder.
fn sentences((_, heading, rudder): Row) -> [String; 2] {
    [format!("HEHDT,{heading:.1},T"), format!("IIRSA,{rudder:.1},A,,V")].map(|body| sentence(&body))
}

#[test]
fn io_sentences_are_read_with_times_before_behind_and_between_them() {
    let is_whole = |t: f64| (t - t.round()).abs() < 0.01;
    let between = |more: &dyn Fn(Row) -> String| {
        text("", |row| {
            let fix = if is_whole(row.0) { fix(row.0) + "\n" } else { String::new() };
            fix + &sentences(row).join("\n") + &more(row)
        })
    };
    let recorder = text("timestamp,type,id,message\n", |row| {
        let line = |sentence: String| format!("{},NMEA0183,,\"{sentence}\"", iso(row.0));
        sentences(row).map(line).join("\n")
    });
    let in_digits = text("", |row| {
        let digits = iso(row.0).replace(['-', 'T', ':', '.', 'Z'], "");
        sentences(row).map(|sentence| format!("{digits},1,{sentence}")).join("\n")
    });
    let whole = text("", |row| {
        let line = |sentence: String| {
            format!("\\s:ST,c:{}*00\\{sentence}", START_S + (row.0 + 1e-9).floor())
        };
        sentences(row).map(line).join("\n")
    });
    let behind = text("", |row| {
        let line = |sentence: String| format!("{sentence},{:.0}", 1e3 * (START_S + row.0));
        sentences(row).map(line).join("\n")
    });
    let transducer = text("", |row| {
        let heading = sentence(&format!("HCHDM,{:.1},M", row.1));
        let rudder = sentence(&format!("IIXDR,C,20.0,C,AIR,A,{:.1},D,RUDR", row.2));
        format!("{} {heading}\n{} {rudder}", iso(row.0), iso(row.0))
    });
    let stuck = text("", |row| {
        let [heading, rudder] = sentences(row);
        [sentence("IIHDT,123.4,T"), heading, rudder]
            .map(|sentence| format!("{} {sentence}", iso(row.0)))
            .join("\n")
    });
    let ordered = text("", |row| {
        let [heading, _] = sentences(row);
        let side = if row.2 < 0.0 { 'L' } else { 'R' };
        let order = sentence(&format!("AGHTD,A,{:.1},{side},M,N,,,,,,,,T", row.2.abs()));
        format!("{} {heading}\n{} {order}", iso(row.0), iso(row.0))
    });
    let attitude = text("", |row| {
        let body =
            format!("PASHR,{},{:.2},T,0.50,-0.20,0.00,0.1,0.1,0.1,1,1", hhmmss(row.0), row.1);
        let [_, rudder] = sentences(row);
        sentence(&body) + "\n" + &rudder
    });
    let none = |_: Row| String::new();
    let second = |(_, heading, _): Row| {
        let heading = (heading + 8.0).rem_euclid(360.0);
        "\n".to_owned() + &sentence(&format!("IIHDT,{heading:.1},T"))
    };
    for (name, log, warning) in [
        ("a voyage recorder", recorder, ""),
        ("times once a second", between(&none), "spread evenly between the times of RMC"),
        ("two compasses", between(&second), "2 instruments send HDT"),
        ("tag blocks of whole seconds", whole, "share the time before them"),
        ("times behind", behind, ""),
        ("a compass that stands still first", stuck, "HE.HDT.heading_deg` is taken"),
        ("a rudder that an autopilot orders", ordered, ""),
        ("dates and times in digits", in_digits, ""),
        ("a rudder by its name", transducer, ""),
        ("an attitude with its own time", attitude, ""),
    ] {
        let warnings = assert_is_the_run(name, log.as_bytes()).join("\n");
        assert!(warnings.contains(warning), "{name}: {warnings}");
    }
}

/// Time in s, identifier, number, source, bytes.
type Frame = (f64, u32, u32, u8, [u8; 8]);

/// Frames of the run.
fn frames() -> Vec<Frame> {
    let count = |degrees: f64| (1e4 * degrees.to_radians()).round();
    let frames = run().into_iter().flat_map(|(time_s, heading, rudder)| {
        let [low, high] = (count(heading) as u16).to_le_bytes();
        let [less, more] = (count(rudder) as i16).to_le_bytes();
        [
            (time_s, 0x09f1_120f, 127_250, 15, [0xff, low, high, 0xff, 0x7f, 0xff, 0x7f, 0xfd]),
            (time_s, 0x09f1_0d1a, 127_245, 26, [0, 0xff, 0xff, 0x7f, less, more, 0xff, 0xff]),
        ]
    });
    frames.collect()
}

#[test]
fn io_frames_of_other_adapters_and_of_the_analyzer_are_read() {
    let hex = |data: &[u8; 8], between: &str| data.map(|byte| format!("{byte:02X}")).join(between);
    let lines = |head: &str, line: &dyn Fn(Frame) -> String| {
        frames().into_iter().fold(head.to_owned(), |mut log, frame| {
            writeln!(log, "{}", line(frame)).unwrap();
            log
        })
    };
    let angle = |number: u32, data: &[u8; 8]| match number {
        127_250 => f64::from(u16::from_le_bytes([data[1], data[2]])) * 1e-4,
        _ => f64::from(i16::from_le_bytes([data[4], data[5]])) * 1e-4,
    };
    let field = |number: u32| {
        if number == 127_250 { "Heading" } else { "Position" }
    };
    for (name, log) in [
        (
            "Yacht Devices, with dates",
            lines("", &|(t, id, _, _, data)| {
                let time = iso(t).replace(['T', 'Z'], " ");
                format!("{time}R {id:08X} {}", hex(&data, " "))
            }),
        ),
        (
            "canboat without dates",
            lines("", &|(t, _, number, source, data)| {
                format!("{},2,{number},{source},255,8,{}", &iso(t)[11..23], hex(&data, ","))
            }),
        ),
        (
            "candump -x",
            lines("", &|(t, id, _, _, data)| {
                format!(" ({:.6})  can0  RX - -  {id:08X}   [8]  {}", START_S + t, hex(&data, " "))
            }),
        ),
        (
            "Vector",
            lines(
                "date Wed May 1 12:00:00 2024\nbase hex  timestamps absolute\n",
                &|(t, id, _, _, data)| {
                    format!("{t:11.6} 1  {id:X}x       Rx   d 8 {}", hex(&data, " "))
                },
            ),
        ),
        (
            "SavvyCAN",
            lines("Time Stamp,ID,Extended,Dir,Bus,LEN,D1,D2,D3,D4,D5,D6,D7,D8\n", &|(
                t,
                id,
                _,
                _,
                data,
            )| {
                format!("{:.0},{id:08X},true,Rx,0,8,{},", 1e6 * t, hex(&data, ","))
            }),
        ),
        (
            "OpenCPN",
            lines("received_at,protocol,msg_type,source,raw_data\n", &|(
                t,
                _,
                number,
                source,
                data,
            )| {
                let [low, mid, high, _] = number.to_le_bytes();
                let ms = 1e3 * (START_S + t);
                format!(
                    "{ms:.0},N2000,{number},{source},\"93 13 02 {low:02X} {mid:02X} {high:02X} FF {source:02X} 00 00 00 00 08 {} 5A \"",
                    hex(&data, " ")
                )
            }),
        ),
        (
            "ShipModul",
            lines("", &|(t, _, number, source, mut data)| {
                data.reverse();
                let body = format!("MXPGN,{number:06X},28{source:02X},{}", hex(&data, ""));
                format!("{:.3} {}", START_S + t, sentence(&body))
            }),
        ),
        (
            "the analyzer's text",
            lines("", &|(t, _, number, source, data)| {
                let (time, degrees) = (iso(t), angle(number, &data).to_degrees());
                format!(
                    "{time} 2 {source:3} 255 {number} Name: of it:  SID = 255; {} = {degrees:.1} deg; Reference = True",
                    field(number)
                )
            }),
        ),
        (
            "the analyzer's camel case",
            lines("{\"version\":\"6\"}\n", &|(t, _, number, source, data)| {
                let (time, radians) = (iso(t), angle(number, &data));
                format!(
                    "{{\"timestamp\":\"{time}\",\"src\":{source},\"pgn\":{number},\"fields\":{{\"{}\":{radians:.4}}}}}",
                    field(number).to_lowercase()
                )
            }),
        ),
    ] {
        assert_is_the_run(name, log.as_bytes());
    }
}

/// A message of an NGT-1 of this kind, with every escape twice.
fn of_gateway(kind: u8, body: &[u8], escapes: &[u8]) -> Vec<u8> {
    let mut message = [&[kind, body.len() as u8], body].concat();
    let sum = message.iter().fold(0_u8, |sum, byte| sum.wrapping_add(*byte));
    message.push(sum.wrapping_neg());
    let twice = |byte: &u8| vec![*byte; 1 + usize::from(escapes.contains(byte))];
    let escaped = message.iter().flat_map(twice);
    [0x10, 0x02].into_iter().chain(escaped).chain([0x10, 0x03]).collect()
}

/// A recording of Actisense has times between the messages of the gateway, or the gateway's own.
#[test]
fn io_recordings_of_a_gateway_are_read_with_times_between_or_in_their_messages() {
    let received = |(t, _, number, source, data): Frame, has_time: bool| {
        let ms = if has_time { (1e3 * t).round() as u32 } else { 0 };
        let [low, mid, high, _] = number.to_le_bytes();
        let head = [&[2, low, mid, high, 255, source][..], &ms.to_le_bytes()].concat();
        [&head[..], &[8], &data].concat()
    };
    let recording = |message: &dyn Fn(Frame) -> Vec<u8>| {
        frames().into_iter().fold(Vec::new(), |mut log, frame| {
            let ticks =
                (1e7 * (START_S + 11_644_473_600.0)) as u64 + (1e7 * frame.0).round() as u64;
            let twice = |byte: u8| vec![byte; 1 + usize::from(byte == 0x1b)];
            log.extend([0x1b, 0x01, 0x03]);
            log.extend(ticks.to_le_bytes().into_iter().flat_map(twice));
            log.extend([0x1b, 0x0a]);
            log.extend(message(frame));
            log
        })
    };
    let sent = |(_, _, number, _, data): Frame| {
        let [low, mid, high, _] = number.to_le_bytes();
        [&[2, low, mid, high, 255, 8][..], &data].concat()
    };
    let both = [0x10, 0x1b];
    let mut inside = frames().into_iter().fold(Vec::new(), |log, frame| {
        [log, of_gateway(0x93, &received(frame, true), &[0x10])].concat()
    });
    inside.drain(..7);
    for (name, log) in [
        ("times between", recording(&|frame| of_gateway(0x93, &received(frame, false), &both))),
        ("own times", recording(&|frame| of_gateway(0x93, &received(frame, true), &both))),
        ("sent", recording(&|frame| of_gateway(0x94, &sent(frame), &both))),
        ("from the middle of a message on", inside),
    ] {
        assert_is_the_run(name, &log);
    }
}

/// Deltas name the PGN of their source, stand in an array, or have their time before them.
#[test]
fn io_deltas_are_read_as_servers_write_them() {
    let delta = |t: f64, path: &str, degrees: f64, has_time: bool| {
        let time = if has_time { format!("\"timestamp\":\"{}\",", iso(t)) } else { String::new() };
        format!(
            "{{\"updates\":[{{\"source\":{{\"label\":\"can0\",\"pgn\":127250,\"src\":\"3\"}},{time}\"values\":[{{\"path\":\"{path}\",\"value\":{:.5}}}]}}]}}",
            degrees.to_radians()
        )
    };
    let both = |(t, heading, rudder): Row, has_time: bool| {
        [
            delta(t, "navigation.headingMagnetic", heading, has_time),
            delta(t, "navigation.attitude.yaw", heading, has_time),
            delta(t, "steering.rudderAngle", rudder, has_time),
        ]
    };
    let array = text("[", |row| both(row, true).join(",\n") + ",") + "]";
    let timed = text("", |row| {
        let line = |delta: String| format!("{:.0};ws;{delta}", 1e3 * (START_S + row.0));
        both(row, false).map(line).join("\n")
    });
    for (name, log) in [
        ("a line each", text("", |row| both(row, true).join("\n"))),
        ("an array", array),
        ("times before", timed),
    ] {
        assert_is_the_run(name, log.as_bytes());
    }
}

#[test]
fn io_what_has_no_time_says_how_to_record_one() {
    let folder = tempfile::tempdir().unwrap();
    for (log, expected) in [
        ("  can0  09F1120F   [8]  FF C0 1E FF 7F FF 7F FD\n", "candump -l"),
        ("$HEHDT,123.4,T*1F\n$IIRSA,1.0,A,,V*78\n", "a time before each sentence"),
        ("\u{89}HDF\r\n\u{1a}\n", "to_csv"),
    ] {
        let bytes: Vec<u8> = log.chars().map(|c| c as u8).collect();
        let error = opened(&bytes, &folder).err().unwrap().to_string();
        assert!(error.contains(expected) && !error.contains("NAME"), "{error}");
    }
}

/// Heave stands beside; an engine's speed can be chosen for the thrust.
#[test]
fn io_heave_and_engines_are_read_past_or_chosen() {
    let engine = [0x09f2_001f_u32, 0x09f1_141e];
    let mut log = String::new();
    for (t, id, _, _, data) in frames() {
        let line = |id: u32, data: [u8; 8]| {
            let data = data.map(|byte| format!("{byte:02X}")).join("");
            format!("({:.6}) can0 {id:08X}#{data}\n", START_S + t)
        };
        log += &line(id, data);
        log += &line(engine[0], [0, 0x70, 0x17, 0xff, 0xff, 0x7f, 0xff, 0xff]);
        log += &line(engine[1], [0xff, 0x0a, 0x00, 0xff, 0xff, 0xff, 0xff, 0xff]);
    }
    assert_is_the_run("heave and an engine", log.as_bytes());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log");
    std::fs::write(&path, &log).unwrap();
    let mut choice = ChannelChoice::default();
    let speed = "engine.31.0.speed_rpm";
    choice.columns.insert(seatrial_logs::Quantity::Thrust, speed.into());
    let mut reader = open(&path, &choice).unwrap();
    let last = reader.by_ref().last().unwrap().unwrap();
    // 1500 rpm as a share of 100.
    assert_eq!(last.thrust, Some(15.0));

    let heave: String = log
        .lines()
        .filter(|line| line.contains("09F1141E"))
        .map(|line| format!("{line}\n"))
        .collect();
    std::fs::write(&path, heave).unwrap();
    let error = open(&path, &ChannelChoice::default()).err().unwrap().to_string();
    assert!(error.contains("127250") && error.contains("heave"), "{error}");
}

#[test]
fn io_a_text_that_is_no_table_is_asked_for_no_column() {
    for (text, expected) in [
        ("FMT, 128, 89, FMT, BBnNZ, Type,Length\nATT, 1, 2\n", "nothing but descriptions"),
        ("{\"time\": 0.1, \"heading\": 2.0, \"rudder\": 3.0}\n", "jq -r"),
        ("[{\"time\": 0.1, \"heading\": 2.0, \"rudder\": 3.0}]", "jq -r"),
        (
            "TITLE = \"run\"\nVARIABLES = \"t\" \"psi\" \"delta\"\nZONE I=2\n0 1 2\n",
            "a data file of Tecplot",
        ),
        ("INSERT INTO log VALUES (0.1, 2.0, 3.0);\n", "SELECT"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let error = opened(text.as_bytes(), &folder).err().unwrap().to_string();
        assert!(error.contains(expected) && !error.contains("--time NAME"), "{error}");
    }
}

/// The third places are 100 m north and 50 m west of the first, to the centimetres of their last digits.
#[test]
fn io_positions_are_read_as_receivers_and_charts_write_them() {
    let rows = |names: &str, places: [&str; 3]| {
        let row = |(k, place): (usize, &str)| format!("{k}.0,{place},{},5\n", 10 + k);
        let rows: String = places.into_iter().enumerate().map(row).collect();
        format!("time_s,{names},heading_deg,rudder_deg\n{rows}")
    };
    let (degrees, receiver, chart, south, autopilot) = (
        ["50.0,-20.0", "50.0,-20.0", "50.0008999,-20.0007000"],
        ["5000.0000,-2000.0000", "5000.0000,-2000.0000", "5000.05400,-2000.04200"],
        ["50°00.000'N,20°00.000'W", "50°00.000'N,20°00.000'W", "50°00.0540'N,20°00.0420'W"],
        ["50°00.000'S,20°00.000'W", "50°00.000'S,20°00.000'W", "49°59.9460'S,20°00.0420'W"],
        ["500000000,-200000000", "500000000,-200000000", "500008999,-200007000"],
    );
    for (names, places) in [
        ("lat,lon", degrees),
        ("lat,lon", receiver),
        ("Latitude,Longitude", chart),
        ("Latitude,Longitude", south),
        ("lat_e7,lon_e7", autopilot),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let log = rows(names, places);
        let last = opened(log.as_bytes(), &folder).unwrap().last().unwrap().unwrap();
        let moved = last.north_m.zip(last.east_m);
        let is_there = |(north_m, east_m): (f64, f64)| {
            (north_m - 100.0).abs() < 0.1 && (east_m + 50.0).abs() < 0.1
        };
        assert!(moved.is_some_and(is_there), "{log}: {last:?}");
    }
}
