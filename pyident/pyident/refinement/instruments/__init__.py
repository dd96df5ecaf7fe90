"""Parts of the instrumental estimate: equations of logs and simulations, steps, noise and intervals."""
