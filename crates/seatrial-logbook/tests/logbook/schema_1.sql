-- A logbook as schema version 1 wrote it. Never edited: it stands for those in the field.
PRAGMA foreign_keys = OFF;
BEGIN TRANSACTION;
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
INSERT INTO "campaign" VALUES(1,1,'2026-11-21T05:11:37Z','0.1.0','sim:starfish',-1,0.26,'speeds = [0.6, 0.8]
','4a9ea1ba1351310e1272ab55116481bef4eae5cc18cc0618f72a9919ae2ae131','{"state":"finished"}',0,'6e2b4ce92298c68e21479a3b7113b80d61dae7a060e74277dc38d89048a009ce','b273fd775ff931bfb66fbbd3faa7803441d73072b96ec8c24064797de37aa433');
CREATE TABLE configuration (
    id    INTEGER PRIMARY KEY,
    name  TEXT NOT NULL UNIQUE,
    notes TEXT
) STRICT;
INSERT INTO "configuration" VALUES(1,'bare hull',NULL);
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
INSERT INTO "estimate" VALUES(1,'{"training":{"from_s":7.0,"to_s":8.0},"samples_used":0,"samples_rejected":{"non_finite":0,"repeated_time":0,"reversed_time":0,"spike":0,"gaps":0},"settings":{"as_paper":true,"lambda_rad_s":12.0,"lambda_because":"given","heading_hold":"first_order","initial_covariance":13.0,"forgetting_factor":14.0},"online":{"method":"instrumental_variable","a22_per_s":15.0,"b2_per_s2":16.0,"c0_rad_per_s2":17.0,"delta0_rad":19.0,"covariance":[[20.0,21.0,22.0],[23.0,24.0,25.0],[26.0,27.0,28.0]],"least_squares":{"a22_per_s":29.0,"b2_per_s2":30.0,"c0_rad_per_s2":31.0,"covariance":[[32.0,33.0,34.0],[35.0,36.0,37.0],[38.0,39.0,40.0]]},"batch":{"a22_per_s":42.0,"b2_per_s2":43.0,"c0_rad_per_s2":44.0},"theta_at":{"100":[45.0,46.0,47.0]},"convergence":{"detected_s":null,"threshold":49.0,"consecutive":0}},"refined":{"method":"restricted_likelihood","a22_per_s":67.0,"b2_per_s2":68.0,"c0_rad_per_s2":69.0,"delta0_rad":null,"interval_95":{"a22_per_s":[71.0,72.0],"b2_per_s2":[73.0,74.0],"c0_rad_per_s2":[75.0,76.0],"delta0_rad":[78.0,79.0]},"covariance":[[80.0,81.0,82.0],[83.0,84.0,85.0],[86.0,87.0,88.0]],"heading_noise_rad":89.0,"disturbance_rad_s2":90.0},"nomoto":null,"validation":null,"verdict":{"accepted":true,"reasons":[{"code":"code","text":"a ''quoted'' \"text\", Δ 93"}]}}');
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
INSERT INTO "run" VALUES(1,1,1,0.8,1,1.63,'{"accepted":true,"reasons":[{"code":"ok","text":"fit to use"}]}',3,'86642cdbcd555eaa5d34dc8246837148666c8008b75f8932acc1cf77aca5cc68');
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
INSERT INTO "sample" VALUES(1,0,1,0.0,3.33333333333333314829e-01,-0.26,NULL,2.0,NULL,NULL,NULL,NULL,NULL,NULL,NULL,0.1,0.8,NULL,NULL,NULL,'settle',NULL);
INSERT INTO "sample" VALUES(1,1,1,0.05,X'7FF8000000000000',-0.26,NULL,2.0,NULL,NULL,NULL,NULL,NULL,NULL,NULL,0.1,0.8,NULL,NULL,NULL,'settle',NULL);
INSERT INTO "sample" VALUES(1,2,1,0.1,3.33333333333333314829e-01,-0.26,NULL,2.0,NULL,NULL,NULL,NULL,NULL,NULL,0.26,NULL,0.8,52.0,53.0,54.0,'train',NULL);
INSERT INTO "sample" VALUES(1,3,NULL,1.50000000000000022204e-01,3.33333333333333314829e-01,-0.26,NULL,2.0,NULL,NULL,NULL,NULL,NULL,NULL,NULL,0.1,0.8,NULL,NULL,NULL,NULL,'{"state":"finished"}');
CREATE TABLE stage (
    run    INTEGER NOT NULL REFERENCES run (id),
    number INTEGER NOT NULL,
    stage  TEXT NOT NULL,
    from_s ANY NOT NULL,
    to_s   ANY NOT NULL,
    PRIMARY KEY (run, number)
) STRICT, WITHOUT ROWID;
INSERT INTO "stage" VALUES(1,0,'train',0.0,0.15);
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
INSERT INTO "trace" VALUES(1,0,0.1,52.0,53.0,54.0,3.33333333333333314829e-01);
CREATE INDEX sample_of_run ON sample (run);
COMMIT;
PRAGMA application_id = 1398033474;
PRAGMA user_version = 1;
