"""What a step computes is recorded here, a part a file; `step_recording` calls the parts in the order of the step."""
