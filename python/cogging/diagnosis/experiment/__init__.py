"""The motion that would tell look-alikes apart."""
