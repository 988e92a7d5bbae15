"""What is measured: step, run, visitors, fairness, peers; and a client without a browser, which tests use, too."""
