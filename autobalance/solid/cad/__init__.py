"""The CAD kernel: solids with exact surfaces, STEP, machining, tessellation."""
