"""The motion between two contact switches, and small deviations from it, by one Taylor recurrence."""
