"""Clips of a model, drawn off screen: tendons coloured by tension, and a panel of charts."""
