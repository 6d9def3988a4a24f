//! The hash chains of what operators commanded and of their reviews: row -> row -> head.

use rusqlite::{Connection, Error, Row};

use super::chain::row_link;

/// A chain.
#[derive(Clone, Copy, Debug)]
pub(super) enum Trail {
    /// Of the commands.
    Commands,
    /// Of the reviews, each with the seal of its run.
    Reviews,
}

impl Trail {
    /// What the chain is of, for messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Commands => "commands",
            Self::Reviews => "reviews",
        }
    }

    fn rows(self) -> &'static str {
        match self {
            Self::Commands => {
                "SELECT id, time, actor, address, command, details, result FROM command
                 WHERE id >= ? ORDER BY id"
            }
            Self::Reviews => {
                "SELECT review.id, review.run, run.campaign, run.number, run.sha256,
                        review.accepted, review.note, review.reviewer, review.time
                 FROM review LEFT JOIN run ON run.id = review.run
                 WHERE review.id >= ? ORDER BY review.id"
            }
        }
    }

    /// The head that is kept.
    pub fn head(self, connection: &Connection) -> Result<String, Error> {
        let sql = match self {
            Self::Commands => "SELECT commands_sha256 FROM trail",
            Self::Reviews => "SELECT reviews_sha256 FROM trail",
        };
        connection.query_row(sql, [], |row| row.get(0))
    }

    /// The head that follows from the rows.
    pub fn recomputed(self, connection: &Connection) -> Result<String, Error> {
        self.linked(connection, String::new(), 0)
    }

    /// Adds the rows from this one on to the chain.
    pub fn seal(self, connection: &Connection, from: i64) -> Result<(), Error> {
        let head = self.linked(connection, self.head(connection)?, from)?;
        let sql = match self {
            Self::Commands => "UPDATE trail SET commands_sha256 = ?",
            Self::Reviews => "UPDATE trail SET reviews_sha256 = ?",
        };
        connection.execute(sql, [head]).map(drop)
    }

    fn linked(self, connection: &Connection, head: String, from: i64) -> Result<String, Error> {
        let mut query = connection.prepare(self.rows())?;
        let mut rows = query.query([from])?;
        let mut head = head;
        while let Some(row) = rows.next()? {
            head = row_link(&head, &values(row)?);
        }
        Ok(head)
    }
}

fn values<'a>(row: &'a Row) -> Result<Vec<rusqlite::types::ValueRef<'a>>, Error> {
    let columns = row.as_ref().column_count();
    (0..columns).map(|column| row.get_ref(column)).collect()
}
