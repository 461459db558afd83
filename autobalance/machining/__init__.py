"""From a report to programs for machine tools: set-ups, moves, dialects, the text simulated on the solid."""
