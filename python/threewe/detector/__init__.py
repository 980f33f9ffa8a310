"""Training of the object detector that instructions see with. What runs it is C++."""
