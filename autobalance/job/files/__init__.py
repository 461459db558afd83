"""The files beside the job: bearings, rotors, readings, trials, designs, lists."""
