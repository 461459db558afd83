"""What every command writes and prints on small inputs, stored: the net under every move of code.

``python -m tests.frozen.regenerate`` stores it anew; the difference is read before it is committed.
"""
