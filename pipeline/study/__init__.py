"""The published study: its statements, tables and report against stored planes; nothing else knows it."""
