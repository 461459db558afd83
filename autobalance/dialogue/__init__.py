"""A job by questions and answers on the terminal."""
