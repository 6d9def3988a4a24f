-- The notes as they stood when the campaign began, and whether its hash covers them. NULL in campaigns from before.
ALTER TABLE campaign ADD COLUMN notes TEXT;
ALTER TABLE campaign ADD COLUMN notes_sealed INTEGER;
