"""What goes with a vessel, as objects of their own: caps, corks, lids, stoppers, labels, print, stands."""
