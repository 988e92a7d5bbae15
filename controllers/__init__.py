"""The mathematics of one tick: numpy, Pinocchio and coal; knows no scene and no page.

Every symbol used below this line is explained once, in `controllers.symbols`.
"""
