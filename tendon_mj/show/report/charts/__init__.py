"""Interactive charts of a report, as plotly figures: plain dictionaries of `data` and `layout`."""
