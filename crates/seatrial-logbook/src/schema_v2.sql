-- The thrust that the vehicle reports with a sample.
ALTER TABLE sample ADD COLUMN thrust ANY;
