"""Joints: two layers of cartilage on bones along a path of poses."""
