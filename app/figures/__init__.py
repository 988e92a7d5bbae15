"""The paper's figures and ours, drawn from runs: `lwr-duet figures`. No browser, no graphics card."""
