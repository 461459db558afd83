"""The loop: measure, plan, cut, measure again."""
