-- Every table is STRICT. A column of type ANY holds a double exactly: REAL, or where it is
-- not a number the eight bytes of its bits.

CREATE TABLE configuration (
    id    INTEGER PRIMARY KEY,
    name  TEXT NOT NULL UNIQUE,
    notes TEXT
) STRICT;

CREATE TABLE campaign (
    id               INTEGER PRIMARY KEY,
    configuration    INTEGER NOT NULL REFERENCES configuration (id),
    started          TEXT NOT NULL,    -- UTC, ISO 8601
    software_version TEXT NOT NULL,
    vehicle          TEXT NOT NULL,
    seed             INTEGER,          -- the 64 bits of an unsigned seed
    rudder_limit_rad ANY NOT NULL,
    plan             TEXT NOT NULL,
    plan_sha256      TEXT NOT NULL,
    outcome          TEXT,             -- JSON; NULL while it runs, or where it was interrupted
    interrupted      INTEGER NOT NULL DEFAULT 0,
    sha256           TEXT NOT NULL,    -- the first link of the hash chain: what it ran on
    head_sha256      TEXT NOT NULL     -- the newest link: its last finished run, then its outcome
) STRICT;

CREATE TABLE run (
    id              INTEGER PRIMARY KEY,
    campaign        INTEGER NOT NULL REFERENCES campaign (id),
    number          INTEGER NOT NULL,  -- 1 for the first run of the campaign
    thrust          ANY NOT NULL,
    attempt         INTEGER NOT NULL,
    surge_speed_m_s ANY,
    verdict         TEXT,              -- JSON
    accepted        INTEGER AS (verdict ->> '$.accepted'),
    sample_count    INTEGER,
    sha256          TEXT,              -- NULL until the run is finished
    UNIQUE (campaign, number)
) STRICT;

CREATE TABLE stage (
    run    INTEGER NOT NULL REFERENCES run (id),
    number INTEGER NOT NULL,
    stage  TEXT NOT NULL,
    from_s ANY NOT NULL,
    to_s   ANY NOT NULL,
    PRIMARY KEY (run, number)
) STRICT, WITHOUT ROWID;

-- The result of a run. The columns for queries are computed from the JSON, so they cannot
-- disagree with it; they are the model that goes to the controller.
CREATE TABLE estimate (
    run             INTEGER PRIMARY KEY REFERENCES run (id),
    identification  TEXT NOT NULL,
    a22_per_s       REAL AS (coalesce(identification ->> '$.refined.a22_per_s',
                                      identification ->> '$.online.a22_per_s')),
    b2_per_s2       REAL AS (coalesce(identification ->> '$.refined.b2_per_s2',
                                      identification ->> '$.online.b2_per_s2')),
    c0_rad_per_s2   REAL AS (coalesce(identification ->> '$.refined.c0_rad_per_s2',
                                      identification ->> '$.online.c0_rad_per_s2')),
    delta0_rad      REAL AS (coalesce(identification ->> '$.refined.delta0_rad',
                                      identification ->> '$.online.delta0_rad')),
    a22_low_per_s   REAL AS (identification ->> '$.refined.interval_95.a22_per_s[0]'),
    a22_high_per_s  REAL AS (identification ->> '$.refined.interval_95.a22_per_s[1]'),
    b2_low_per_s2   REAL AS (identification ->> '$.refined.interval_95.b2_per_s2[0]'),
    b2_high_per_s2  REAL AS (identification ->> '$.refined.interval_95.b2_per_s2[1]'),
    nomoto_t_s      REAL AS (identification ->> '$.nomoto.t_s'),
    nomoto_k_per_s  REAL AS (identification ->> '$.nomoto.k_per_s'),
    r2_heading      REAL AS (identification ->> '$.validation.r2_heading')
) STRICT;

-- The estimate after every sample of the training stage.
CREATE TABLE trace (
    run           INTEGER NOT NULL REFERENCES run (id),
    number        INTEGER NOT NULL,
    time_s        ANY NOT NULL,
    a22_per_s     ANY NOT NULL,
    b2_per_s2     ANY NOT NULL,
    c0_rad_per_s2 ANY NOT NULL,
    step_norm     ANY NOT NULL,
    PRIMARY KEY (run, number)
) STRICT, WITHOUT ROWID;

-- Every sample of a campaign, the action that answered it and the live estimate after it.
CREATE TABLE sample (
    campaign               INTEGER NOT NULL REFERENCES campaign (id),
    number                 INTEGER NOT NULL,
    run                    INTEGER REFERENCES run (id), -- NULL before the first and after the last
    time_s                 ANY NOT NULL,
    heading_rad            ANY NOT NULL,
    rudder_rad             ANY NOT NULL,
    surge_speed_m_s        ANY,
    depth_m                ANY,
    altitude_m             ANY,
    roll_rad               ANY,
    pitch_rad              ANY,
    yaw_rate_rad_s         ANY,
    north_m                ANY,
    east_m                 ANY,
    action_rudder_rad      ANY,        -- the rudder commanded, or
    action_heading_rad     ANY,        -- the heading to hold
    action_thrust          ANY,
    estimate_a22_per_s     ANY,
    estimate_b2_per_s2     ANY,
    estimate_c0_rad_per_s2 ANY,
    stage                  TEXT,
    action_outcome         TEXT,       -- JSON; set in the last action of a trial
    PRIMARY KEY (campaign, number)
) STRICT, WITHOUT ROWID;

CREATE INDEX sample_of_run ON sample (run);
