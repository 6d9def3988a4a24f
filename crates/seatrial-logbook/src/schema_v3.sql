-- What operators commanded, and their word on runs. Neither is part of the hash chain: both may come after a
-- campaign was sealed.

CREATE TABLE command (
    id      INTEGER PRIMARY KEY,
    time    TEXT NOT NULL,     -- UTC, ISO 8601
    actor   TEXT NOT NULL,
    address TEXT NOT NULL,     -- network address
    command TEXT NOT NULL,
    details TEXT NOT NULL,     -- JSON
    result  TEXT NOT NULL      -- done, or the code of the refusal
) STRICT;

-- The last review of a run counts.
CREATE TABLE review (
    id       INTEGER PRIMARY KEY,
    run      INTEGER NOT NULL REFERENCES run (id),
    accepted INTEGER NOT NULL,
    note     TEXT NOT NULL,
    reviewer TEXT NOT NULL,
    time     TEXT NOT NULL     -- UTC, ISO 8601
) STRICT;

CREATE INDEX review_of_run ON review (run);
