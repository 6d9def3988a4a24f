-- The newest links of two hash chains over the whole logbook: of what operators commanded, and of their reviews.
CREATE TABLE trail (
    id              INTEGER PRIMARY KEY CHECK (id = 1),
    commands_sha256 TEXT NOT NULL,
    reviews_sha256  TEXT NOT NULL
) STRICT;
INSERT INTO trail VALUES (1, '', '');
