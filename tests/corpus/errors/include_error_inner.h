float broken(float x) { return missing * x; }
