"""Names of the bundled designs, for the help of the command: it loads no design."""

PRESET_NAMES = (
    "single",
    "pressed-up-single",
    "pressed-up-single-no-pin",
    "v-twin-45",
    "parallel-twin-360",
    "inline-3",
    "inline-4",
    "inline-6",
    "v6-60",
    "v8-crossplane",
    "v8-flatplane",
    "v12-60",
)
