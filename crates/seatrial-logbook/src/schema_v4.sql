-- Trials of the pitch axis. One is entered whole when it is over.

CREATE TABLE pitch_trial (
    id               INTEGER PRIMARY KEY,
    configuration    TEXT NOT NULL,
    entered          TEXT NOT NULL,     -- UTC, ISO 8601
    software_version TEXT NOT NULL,
    vehicle          TEXT NOT NULL,
    seed             INTEGER,
    plan             TEXT NOT NULL,     -- JSON
    result           TEXT NOT NULL,     -- JSON: the runs, and why it was aborted
    sha256           TEXT NOT NULL
) STRICT;

CREATE TABLE pitch_sample (
    trial           INTEGER NOT NULL REFERENCES pitch_trial (id),
    number          INTEGER NOT NULL,
    time_s          ANY NOT NULL,
    pitch_rad       ANY NOT NULL,
    elevator_rad    ANY NOT NULL,
    depth_m         ANY,
    surge_speed_m_s ANY,
    PRIMARY KEY (trial, number)
) STRICT, WITHOUT ROWID;
