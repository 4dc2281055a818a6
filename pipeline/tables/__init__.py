"""Tables 1 to 3 of the study, made from stored planes."""
