# The tests of the core: one list for the host and for the microcontrollers.
set(BISS_CORE_TESTS ../../firmware/boards_run/encoder_start_test.cpp axis_dma_test.cpp
                    axis_position_test.cpp axis_test.cpp banked_registers_test.cpp base_test.cpp catalogue_test.cpp
                    channel_test.cpp configure_eds_test.cpp configure_hostile_test.cpp
                    configure_test.cpp control_ahead_test.cpp control_chain_test.cpp control_damage_test.cpp
                    control_failure_test.cpp control_hostile_test.cpp control_link_test.cpp
                    control_sequence_test.cpp control_session_test.cpp crc_test.cpp
                    eds_advise_test.cpp eds_check_test.cpp eds_device_test.cpp eds_image_test.cpp
                    eds_part_test.cpp eds_profile_test.cpp encoder_axis_test.cpp
                    encoder_link_test.cpp fixed_test.cpp format_test.cpp frame_test.cpp
                    master_slave_test.cpp mistakes_test.cpp named_device_test.cpp
                    polled_axis_test.cpp polled_test.cpp quick_test.cpp register_map_test.cpp
                    register_server_test.cpp request_end_test.cpp request_kind_test.cpp
                    request_test.cpp safe_axis_test.cpp safety_counter_test.cpp
                    safety_evaluation_test.cpp safety_kinds_test.cpp safety_memory_test.cpp
                    safety_monitor_test.cpp safety_self_test_test.cpp safety_setup_test.cpp
                    safety_states_test.cpp safety_time_test.cpp slave_chain_test.cpp
                    slave_test.cpp spi_test.cpp timing_test.cpp turns_test.cpp)
