"""Made recordings of five rigs, each with one fault of a logger or none: is it named, and where?"""
