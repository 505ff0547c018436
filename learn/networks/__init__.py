"""The network MVTrans: as the paper describes it (`mvtrans`), and as it was released (`reference`)."""
