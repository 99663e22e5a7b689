"""Solids of eight-node bricks with positions and gradients: functions, laws, loads, faces and the linear body."""
