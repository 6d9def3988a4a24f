-- The vehicle's rudder at full steering, and the faults that a rehearsal met. NULL in campaigns from before.
ALTER TABLE campaign ADD COLUMN full_rudder_rad ANY;
ALTER TABLE campaign ADD COLUMN full_rudder_assumed INTEGER; -- 1: nobody told the angle
ALTER TABLE campaign ADD COLUMN scenario TEXT;               -- the file of the faults
