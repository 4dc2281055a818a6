"""Running a plan: workers, dispatch, rows, progress, and the stages that fill and check a store."""
