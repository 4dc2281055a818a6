"""From what is typed to a checked configuration: composition, schema, files, quantities with units."""
