"""Lu, Chen, Yao, Wang 2008: B-spline cogging model, ARC and DCARC, Tables 1 and 2."""
